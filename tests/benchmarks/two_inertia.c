/* The averaged drive with two inertias in plain C: speed loop, current lag, viscous and dry friction on both sides, a
 * spring with damper over a dead zone between them. The yardstick of bench_fidelities.py, written from the equations as
 * one would by hand. */
#include "by_hand.h"

/* Integrates all rows under the speed setpoint. */
void advance(const plant_t *p, state_t *s, const double *setpoint, long rows, double interval, double step)
{
    const long steps = (long)ceil(interval / step - 1e-9);
    const double h = interval / steps, half = 0.5 * h;
    const double current_gain = 1.0 - exp(-h / p->current_lag), smoothing_gain = 1.0 - exp(-h / p->speed_smoothing);
    const double ceiling = fmin(p->torque_limit, p->current_limit * p->nominal_torque_constant);
    const double gain = h / p->motor_inertia, drag = 1.0 / (1.0 + gain * p->motor_viscous), share = gain * drag;
    const double output_gain = h / p->output_inertia, output_drag = 1.0 / (1.0 + output_gain * p->output_viscous);
    const double output_share = output_gain * output_drag;
    const double sliding = share * p->motor_dry, holding = share * p->motor_break_away;
    const double output_sliding = output_share * p->output_dry, output_holding = output_share * p->output_break_away;
    const double stiffness = p->contact_stiffness, damping = p->contact_damping, gap = p->gap;
    const double damped = 1.0 / (1.0 + damping * half * (1.0 / p->motor_inertia + 1.0 / p->output_inertia));
    const double torque_constant = p->torque_constant;

    double angle = s->motor_angle, speed = s->motor_speed;
    double output_angle = s->output_angle, output_speed = s->output_speed;
    double current = s->current, current_setpoint = s->current_setpoint;
    double integral = s->integral, smoothed = s->smoothed_speed, phase = s->control_phase;

    for (long row = 1; row < rows; row++) {
        const double start = setpoint[row - 1], slope = setpoint[row] - start;
        for (long k = 0; k < steps; k++) {
            if (phase >= p->control_cycle - half) {
                phase -= p->control_cycle;
                const double wanted_speed = start + slope * ((double)k / steps) + slope * (p->control_cycle / interval);
                const double error = wanted_speed - speed;
                const double wanted = p->speed_gain * error + integral;
                const double torque = limited(wanted, ceiling);
                const double rate = p->speed_gain / p->integral_time * error + (torque - wanted) / p->anti_windup_time;
                integral = limited(integral + p->control_cycle * rate, p->integral_limit);
                current_setpoint = torque / p->nominal_torque_constant;
            }
            current += current_gain * (current_setpoint - current);
            phase += h;

            const double twist = angle - output_angle, twist_speed = speed - output_speed, before = speed;
            double passed;
            if (gap == 0.0) {
                passed = (stiffness * (twist + half * twist_speed) + damping * twist_speed) * damped;
            } else {
                const double side = twist + half * twist_speed > 0.0 ? 1.0 : -1.0;
                const double depth = side * twist - gap, depth_after = depth + side * h * twist_speed;
                double torque = 0.0;
                if (depth >= 0.0)
                    torque = (0.5 * stiffness * (depth + depth_after) + damping * side * twist_speed) * damped;
                else if (depth_after > 0.0) /* the teeth meet within the step */
                    torque = depth_after / (depth_after - depth) *
                             (0.5 * stiffness * depth_after + damping * side * twist_speed) * damped;
                passed = torque > 0.0 ? side * torque : 0.0;
            }
            angle += half * speed;
            output_angle += half * output_speed;
            speed = after_dry_friction(speed * drag + share * (torque_constant * current - passed), speed, sliding, holding);
            output_speed = after_dry_friction(output_speed * output_drag + output_share * passed, output_speed,
                                              output_sliding, output_holding);
            angle += half * speed;
            output_angle += half * output_speed;
            smoothed += smoothing_gain * (0.5 * (before + speed) - smoothed);
        }
    }
    s->motor_angle = angle, s->motor_speed = speed, s->output_angle = output_angle, s->output_speed = output_speed;
    s->current = current, s->current_setpoint = current_setpoint, s->integral = integral;
    s->smoothed_speed = smoothed, s->control_phase = phase;
}
