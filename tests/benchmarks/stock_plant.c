/* The stock model's equations in plain C: averaged drive under a speed setpoint, rigid transmission, viscous and dry
 * friction, smoothed speed. The yardstick of bench_plant.py, written from the equations as one would by hand. */
#include "by_hand.h"

void advance(const plant_t *p, state_t *s, const double *setpoint, long rows, double interval, double step)
{
    double angle = s->motor_angle, speed = s->motor_speed, current = s->current;
    double current_setpoint = s->current_setpoint, integral = s->integral, smoothed = s->smoothed_speed;
    double phase = s->control_phase;
    const long steps = (long)ceil(interval / step - 1e-9);
    const double h = interval / steps;
    const double current_gain = 1.0 - exp(-h / p->current_lag);
    const double smoothing_gain = 1.0 - exp(-h / p->speed_smoothing);
    const double gain = h / (p->motor_inertia + p->output_inertia);
    const double drag = 1.0 / (1.0 + gain * (p->motor_viscous + p->output_viscous));
    const double sliding = gain * (p->motor_dry + p->output_dry) * drag;
    const double holding = gain * (p->motor_break_away + p->output_break_away) * drag;

    for (long row = 1; row < rows; row++) {
        const double start = setpoint[row - 1], slope = setpoint[row] - start;
        for (long k = 0; k < steps; k++) {
            if (phase >= p->control_cycle - 0.5 * h) {
                phase -= p->control_cycle;
                const double wanted_speed = start + slope * ((double)k / steps) + slope * (p->control_cycle / interval);
                const double error = wanted_speed - speed;
                const double wanted = p->speed_gain * error + integral;
                const double torque = limited(wanted, p->torque_limit);
                const double rate = p->speed_gain / p->integral_time * error + (torque - wanted) / p->anti_windup_time;
                integral = limited(integral + p->control_cycle * rate, p->integral_limit);
                current_setpoint = torque / p->torque_constant;
            }
            current += current_gain * (current_setpoint - current);
            phase += h;
            angle += 0.5 * h * speed;
            const double before = speed;
            const double free_speed = (speed + gain * p->torque_constant * current) * drag;
            speed = after_dry_friction(free_speed, speed, sliding, holding);
            angle += 0.5 * h * speed;
            smoothed += smoothing_gain * (0.5 * (before + speed) - smoothed);
        }
    }
    s->motor_angle = angle, s->motor_speed = speed, s->current = current, s->current_setpoint = current_setpoint;
    s->integral = integral, s->smoothed_speed = smoothed, s->control_phase = phase;
}
