/* The whole step of the switching drive with the planetary train in plain C: speed loop, hysteresis inverter, star
 * winding, acquisition, meshes, friction of teeth and bearings. The yardstick of bench_fidelities.py, written from the
 * equations as one would by hand for the model `polito_hff`: no faults, a rigid shaft, constant friction. */
#include "by_hand.h"

enum { LANE = 4 }; /* three planets and an empty place, so that all fit one register */
typedef double lane_t[LANE];

typedef struct {
    lane_t stiffness, arm_1, arm_2, force, friction;
} mesh_t;

static const double TURN = 2.0 * 3.14159265358979323846;
static const double HALF_ROOT_OF_THREE = 0.86602540378443864676;

static inline double lag_gain(double step, double lag) { return lag > 0.0 ? 1.0 - exp(-step / lag) : 1.0; }

static inline double comparator(double error, double hysteresis, double leg)
{
    return error < -hysteresis ? 1.0 : error > hysteresis ? -1.0 : leg;
}

/* Force of a mesh over its dead zone; its damper acts while the teeth touch. */
static inline double mesh_force(double depth, double stiffness, double half_play, double damped)
{
    const double beyond = depth > half_play ? depth - half_play : depth < -half_play ? depth + half_play : 0.0;
    return beyond == 0.0 ? 0.0 : stiffness * beyond + damped;
}

static inline double sum(const double *lane) { return lane[0] + lane[1] + lane[2]; }

/* Stiffness and friction's arms of the meshes of one type, at the first planet's mesh cycle `x`. */
static void read_mesh(mesh_t *mesh, const double *table, long points, double x, double teeth, double opposite_flank)
{
    for (int planet = 0; planet < LANE - 1; planet++) {
        const double own = x + teeth * planet / 3.0;
        const double place = mesh->force[planet] >= 0.0 ? own : opposite_flank - own;
        const double at = (place - floor(place)) * points;
        const long low = at >= points ? points - 1 : (long)at;
        const double share = at - low, *here = table + 4 * low, *next = here + 4;
        mesh->stiffness[planet] = here[0] + share * (next[0] - here[0]) + here[1] + share * (next[1] - here[1]);
        mesh->arm_1[planet] = here[2] + share * (next[2] - here[2]);
        mesh->arm_2[planet] = here[3] + share * (next[3] - here[3]);
    }
}

/* Integrates all rows under the speed setpoint; `spin` holds the planets' angles, then their speeds. */
void advance(const plant_t *p, state_t *s, const winding_t *w, winding_state_t *ws, const train_t *t, train_state_t *ts,
             const double *table, long points, double *spins, const double *setpoint, long rows, double interval,
             double step)
{
    const long steps = (long)ceil(interval / step - 1e-9);
    const double h = interval / steps, half = 0.5 * h, ratio = p->gear_ratio, per_ratio = 1.0 / ratio;
    /* drive */
    const double ceiling = fmin(p->torque_limit, p->current_limit * p->nominal_torque_constant);
    const double filter = lag_gain(h, w->current_filter), smoothing = lag_gain(h, p->speed_smoothing);
    /* winding */
    const double pairs = w->pole_pairs, half_link = 0.5 * w->dc_link_voltage, hysteresis = w->hysteresis;
    const double limit = w->torque_limit, peak = w->torque_constant / (1.5 * w->back_emf_constant);
    const double current_scale = w->back_emf_constant / w->torque_constant, voltage_scale = 2.0 / 3.0;
    const double emf_constant = w->back_emf_constant * w->magnet_strength;
    const double r = w->phase_resistance + w->switch_resistance, g = 1.0 / (w->phase_inductance / h + 0.5 * r);
    const double own_phase = g * 2.0 / 3.0, other_phase = -g / 3.0;
    /* shafts */
    const double gain = h / t->input_inertia, drag = 1.0 / (1.0 + gain * p->motor_viscous);
    const double share = gain * drag;
    const double output_gain = h / p->output_inertia, output_drag = 1.0 / (1.0 + output_gain * p->output_viscous);
    const double output_share = output_gain * output_drag;
    const double dry = p->motor_dry, held = p->motor_break_away;
    const double output_dry = p->output_dry, output_held = p->output_break_away;
    /* train */
    const double r_s = t->sun_radius, r_p = t->planet_radius, r_p2 = t->second_planet_radius;
    const double r_o = t->output_ring_radius, r_sp = r_s + r_p, r_pr = r_p - t->ring_radius, r_po = r_p2 - r_o;
    const double damping_s = t->damping[0], damping_r = t->damping[1], damping_o = t->damping[2];
    const double play_s = t->half_play[0], play_r = t->half_play[1], play_o = t->half_play[2];
    const double mu = t->friction_coefficient, *across = t->tangential_stiffness;
    const double across_s = h * across[0], across_r = h * across[1], across_o = h * across[2];
    const double kick = h / t->planet_inertia, carrier_kick = h / t->carrier_inertia;
    const double per_sun = t->sun_teeth / TURN, per_ring = t->ring_teeth / TURN, per_out = t->output_ring_teeth / TURN;
    const double carrier_origin = s->motor_angle_origin * r_s / (r_s + t->ring_radius);
    const double output_origin = carrier_origin * (1.0 - t->ring_radius * r_p2 / (r_p * r_o));
    const double refresh = t->refresh;

    double angle = s->motor_angle, speed = s->motor_speed;
    double output_angle = s->output_angle, output_speed = s->output_speed;
    double carrier_angle = ts->carrier_angle, carrier_speed = ts->carrier_speed;
    double integral = s->integral, current_setpoint = s->current_setpoint, smoothed = s->smoothed_speed;
    double phase = s->control_phase, sine = 0.0, cosine = 1.0;
    double i_u = ws->phase_current_u, i_v = ws->phase_current_v;
    double leg_u = ws->leg_u, leg_v = ws->leg_v, leg_w = ws->leg_w;
    double current = s->current, direct = ws->direct_current, voltage = ws->quadrature_voltage;
    double read_s = INFINITY, read_r = INFINITY, read_o = INFINITY;
    double at_s = 0.0, at_r = 0.0, at_o = 0.0;
    mesh_t sun = {0}, ring = {0}, out = {0};
    lane_t spin, spin_speed;
    for (int i = 0; i < LANE; i++)
        spin[i] = spins[i], spin_speed[i] = spins[LANE + i];

    for (long row = 1; row < rows; row++) {
        const double start = setpoint[row - 1], slope = setpoint[row] - start;
        for (long k = 0; k < steps; k++) {
            const int cycle_begins = phase >= p->control_cycle - half;
            if (cycle_begins) {
                phase -= p->control_cycle;
                const double wanted_speed = start + slope * ((double)k / steps) + slope * (p->control_cycle / interval);
                const double error = wanted_speed - speed;
                const double wanted = p->speed_gain * error + integral;
                const double torque = limited(wanted, ceiling);
                const double rate = p->speed_gain / p->integral_time * error + (torque - wanted) / p->anti_windup_time;
                integral = limited(integral + p->control_cycle * rate, p->integral_limit);
                current_setpoint = torque / p->nominal_torque_constant;
            }
            phase += h;

            /* electrical angle at the middle of the step: anew with every cycle, else turned on */
            if (k == 0 || cycle_begins) {
                sincos(pairs * (s->motor_angle_origin + angle + half * speed), &sine, &cosine);
            } else {
                const double part = pairs * h * speed, square = part * part, before = sine;
                const double rise = part - part * square * (1.0 / 6.0), fall = square * (0.5 - square * (1.0 / 24.0));
                sine += cosine * rise - sine * fall;
                cosine -= before * rise + cosine * fall;
            }
            const double middle = -0.5 * sine, across = HALF_ROOT_OF_THREE * cosine;
            const double shape_v = middle - across, shape_w = middle + across;
            /* comparators and bridge */
            const double amplitude = peak * current_setpoint;
            leg_u = comparator(i_u - amplitude * sine, hysteresis, leg_u);
            leg_v = comparator(i_v - amplitude * shape_v, hysteresis, leg_v);
            leg_w = comparator(-(i_u + i_v) - amplitude * shape_w, hysteresis, leg_w);
            const double v_u = half_link * leg_u, v_v = half_link * leg_v, v_w = half_link * leg_w;
            /* star winding by the midpoint rule */
            const double e_u = emf_constant * sine, e_v = emf_constant * shape_v, e_w = emf_constant * shape_w;
            const double free_w = v_w - e_w * speed + r * (i_u + i_v);
            const double across_u = v_u - e_u * speed - r * i_u - free_w;
            const double across_v = v_v - e_v * speed - r * i_v - free_w;
            const double change_u = own_phase * across_u + other_phase * across_v;
            const double change_v = other_phase * across_u + own_phase * across_v;
            const double m_u = i_u + 0.5 * change_u, m_v = i_v + 0.5 * change_v, m_w = -(m_u + m_v);
            i_u += change_u, i_v += change_v;
            const double torque = limited(e_u * m_u + e_v * m_v + e_w * m_w, limit);
            /* acquisition */
            const double real = m_u - 0.5 * (m_v + m_w), imaginary = HALF_ROOT_OF_THREE * (m_v - m_w);
            const double real_v = v_u - 0.5 * (v_v + v_w), imaginary_v = HALF_ROOT_OF_THREE * (v_v - v_w);
            current += filter * (current_scale * (sine * real - cosine * imaginary) - current);
            direct += filter * (current_scale * (-cosine * real - sine * imaginary) - direct);
            voltage += filter * (voltage_scale * (sine * real_v - cosine * imaginary_v) - voltage);

            /* half the drift */
            angle += half * speed;
            output_angle += half * output_speed;
            const double carrier = carrier_angle + half * carrier_speed, output = output_angle * per_ratio;
            const double slow = output_speed * per_ratio, before = speed;
            /* the meshes, where they have moved on */
            const double own_carrier = carrier_origin + carrier;
            at_s = per_sun * (s->motor_angle_origin + angle - own_carrier) + t->mesh_phase[0];
            at_r = per_ring * own_carrier + t->mesh_phase[1];
            at_o = per_out * (own_carrier - output_origin - output) + t->mesh_phase[2];
            if (fabs(at_s - read_s) >= refresh || fabs(at_r - read_r) >= refresh || fabs(at_o - read_o) >= refresh) {
                read_s = at_s, read_r = at_r, read_o = at_o;
                read_mesh(&sun, table, points, at_s, -t->sun_teeth, t->opposite_flank[0]);
                read_mesh(&ring, table + 4 * (points + 1), points, at_r, t->ring_teeth, t->opposite_flank[1]);
                read_mesh(&out, table + 8 * (points + 1), points, at_o, t->output_ring_teeth, t->opposite_flank[2]);
            }
            /* planets, all at once */
            const double d_s = r_s * angle - r_sp * carrier, d_r = r_pr * carrier, d_o = r_po * carrier + r_o * output;
            const double v_s = r_s * speed - r_sp * carrier_speed, v_r = r_pr * carrier_speed;
            const double v_o = r_po * carrier_speed + r_o * slow;
            lane_t on_sun, on_carrier, on_output;
            for (int i = 0; i < LANE; i++) {
                const double w_p = spin_speed[i], phi = spin[i] + half * w_p;
                const double f_s = mesh_force(d_s + r_p * phi, sun.stiffness[i], play_s, damping_s * (v_s + r_p * w_p));
                const double f_r = mesh_force(d_r - r_p * phi, ring.stiffness[i], play_r, damping_r * (v_r - r_p * w_p));
                const double f_o = mesh_force(d_o - r_p2 * phi, out.stiffness[i], play_o, damping_o * (v_o - r_p2 * w_p));
                sun.force[i] = f_s, ring.force[i] = f_r, out.force[i] = f_o;
                const double sun_arm = sun.arm_1[i], planet_arm_s = sun.arm_2[i], both_s = sun_arm + planet_arm_s;
                const double planet_arm_r = ring.arm_1[i], both_r = planet_arm_r - ring.arm_2[i];
                const double planet_arm_o = out.arm_1[i], out_arm = out.arm_2[i], both_o = planet_arm_o - out_arm;
                const double slide_s = sun_arm * speed - both_s * carrier_speed + planet_arm_s * w_p;
                const double slide_r = both_r * carrier_speed - planet_arm_r * w_p;
                const double slide_o = both_o * carrier_speed - planet_arm_o * w_p + out_arm * slow;
                const double q_s = limited(sun.friction[i] + across_s * slide_s, mu * fabs(f_s));
                const double q_r = limited(ring.friction[i] + across_r * slide_r, mu * fabs(f_r));
                const double q_o = limited(out.friction[i] + across_o * slide_o, mu * fabs(f_o));
                sun.friction[i] = q_s, ring.friction[i] = q_r, out.friction[i] = q_o;
                on_sun[i] = -r_s * f_s - sun_arm * q_s;
                on_carrier[i] = r_sp * f_s + both_s * q_s - r_pr * f_r - both_r * q_r - r_po * f_o - both_o * q_o;
                on_output[i] = -r_o * f_o - out_arm * q_o;
                const double on_planet = -r_p * f_s - planet_arm_s * q_s + r_p * f_r + planet_arm_r * q_r + r_p2 * f_o +
                                         planet_arm_o * q_o;
                const double after = w_p + kick * on_planet;
                spin_speed[i] = after;
                spin[i] = phi + half * after;
            }
            carrier_speed += carrier_kick * sum(on_carrier);
            carrier_angle = carrier + half * carrier_speed;
            /* shafts */
            speed = after_dry_friction(speed * drag + share * (torque + sum(on_sun)), speed, share * dry, share * held);
            output_speed = after_dry_friction(output_speed * output_drag + output_share * sum(on_output) * per_ratio,
                                              output_speed, output_share * output_dry, output_share * output_held);
            angle += half * speed;
            output_angle += half * output_speed;
            smoothed += smoothing * (0.5 * (before + speed) - smoothed);
        }
    }

    s->motor_angle = angle, s->motor_speed = speed, s->output_angle = output_angle, s->output_speed = output_speed;
    s->integral = integral, s->current_setpoint = current_setpoint, s->current = current, s->smoothed_speed = smoothed;
    s->control_phase = phase;
    ts->carrier_angle = carrier_angle, ts->carrier_speed = carrier_speed;
    ws->phase_current_u = i_u, ws->phase_current_v = i_v, ws->direct_current = direct, ws->quadrature_voltage = voltage;
    ws->leg_u = leg_u, ws->leg_v = leg_v, ws->leg_w = leg_w;
    for (int i = 0; i < LANE; i++)
        spins[i] = spin[i], spins[LANE + i] = spin_speed[i];
}
