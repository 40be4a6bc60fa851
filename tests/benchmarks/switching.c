/* The electrical side of the switching drive in plain C: resolver, comparators, bridge, star winding by the midpoint
 * rule, torque and acquisition, at a fixed speed. The yardstick of bench_switching.py, written from the equations as one
 * would by hand. */
#define _GNU_SOURCE /* sincos */
#include <math.h>

typedef struct {
    double u, v, w;
} three_t; /* a value for each phase */

typedef struct { /* the package's own record: plant/switching/layout.py */
    double pole_pairs, phase_resistance, phase_inductance, back_emf_constant, torque_constant, trapezoidal, torque_limit;
    double magnet_strength;
    three_t active_turns;
    double eccentricity, eccentricity_phase, resolver_offset, resolver_amplitude, resolver_order, resolver_phase;
    double dc_link_voltage, hysteresis, switch_resistance, current_filter;
} winding_t;

typedef struct {
    three_t current, leg;
    double quadrature_current, direct_current, quadrature_voltage;
    double angle, torque, air_gap_torque, link_energy, loss_energy;
} state_t;

static const double PI = 3.14159265358979323846;
static const double HALF_ROOT_OF_THREE = 0.86602540378443864676;

static inline double dot(three_t a, three_t b) { return a.u * b.u + a.v * b.v + a.w * b.w; }

static inline double trapezoid(double turns)
{
    const double later = turns + 0.75;
    const double triangle = 3.0 * (4.0 * fabs(later - floor(later) - 0.5) - 1.0);
    return triangle > 1.0 ? 1.0 : triangle < -1.0 ? -1.0 : triangle;
}

static inline three_t shapes(int trapezoidal, double turns, double sine, double cosine)
{
    if (trapezoidal)
        return (three_t){trapezoid(turns), trapezoid(turns - 1.0 / 3.0), trapezoid(turns + 1.0 / 3.0)};
    const double half = -0.5 * sine, across = HALF_ROOT_OF_THREE * cosine;
    return (three_t){sine, half - across, half + across};
}

static inline double block(double shape) { return fabs(shape) == 1.0 ? shape : 0.0; }

static inline double comparator(double error, double hysteresis, double leg)
{
    return error < -hysteresis ? 1.0 : error > hysteresis ? -1.0 : leg;
}

/* Integrates `steps` steps of `h` seconds at a constant speed and setpoint; the angle's sine and cosine are turned on by
 * the angle-sum rule and begin anew every `cycle` steps. */
void advance(const winding_t *w, state_t *s, long steps, long cycle, double h, double setpoint, double speed)
{
    three_t i = s->current, leg = s->leg;
    double quadrature = s->quadrature_current, direct = s->direct_current, voltage = s->quadrature_voltage;
    double angle = s->angle, torque = 0.0, air_gap_torque = 0.0, link_energy = 0.0, loss_energy = 0.0;
    const int trapezoidal = w->trapezoidal != 0.0, eccentric = w->eccentricity != 0.0;
    const int off = w->resolver_offset != 0.0 || w->resolver_amplitude != 0.0;
    const double half_link = 0.5 * w->dc_link_voltage, hysteresis = w->hysteresis, limit = w->torque_limit;
    const double amplitude = setpoint * w->torque_constant / ((trapezoidal ? 2.0 : 1.5) * w->back_emf_constant);
    const double current_scale = w->back_emf_constant / w->torque_constant, voltage_scale = trapezoidal ? 0.5 : 2.0 / 3.0;
    const double filter = w->current_filter > 0.0 ? 1.0 - exp(-h / w->current_filter) : 1.0;
    const double turns = w->pole_pairs / (2.0 * PI);
    const three_t n = w->active_turns;
    const double emf_constant = w->back_emf_constant * w->magnet_strength;
    const three_t k = {emf_constant * n.u, emf_constant * n.v, emf_constant * n.w};
    const double switches = w->switch_resistance, resistance = w->phase_resistance, inductance = w->phase_inductance / h;
    const three_t r = {resistance * n.u + switches, resistance * n.v + switches, resistance * n.w + switches};
    const three_t g = {1.0 / (inductance * n.u * n.u + 0.5 * r.u), 1.0 / (inductance * n.v * n.v + 0.5 * r.v),
                       1.0 / (inductance * n.w * n.w + 0.5 * r.w)};
    const double sum = g.u + g.v + g.w;
    const double uu = g.u * (g.v + g.w) / sum, uv = -g.u * g.v / sum, vv = g.v * (g.u + g.w) / sum;

    const double part = w->pole_pairs * h * speed, square = part * part;
    const double rise = part - part * square / 6.0, fall = square * (0.5 - square / 24.0);
    double sine = 0.0, cosine = 1.0;
    long left = 0;

    for (long step = 0; step < steps; step++) {
        const double middle = angle + 0.5 * h * speed;
        if (left-- == 0) {
            left = cycle - 1;
            sincos(w->pole_pairs * middle, &sine, &cosine);
        } else {
            const double before = sine;
            sine += cosine * rise - sine * fall;
            cosine -= before * rise + cosine * fall;
        }
        const three_t shape = shapes(trapezoidal, turns * middle, sine, cosine);
        double shown_sine = sine, shown_cosine = cosine;
        three_t shown = shape;
        if (off) {
            const double error =
                w->resolver_offset + w->resolver_amplitude * sin(w->resolver_order * middle + w->resolver_phase);
            sincos(w->pole_pairs * (middle + error), &shown_sine, &shown_cosine);
            shown = shapes(trapezoidal, turns * (middle + error), shown_sine, shown_cosine);
        }
        const three_t carried = trapezoidal ? (three_t){block(shown.u), block(shown.v), block(shown.w)} : shown;

        leg.u = comparator(i.u - amplitude * carried.u, hysteresis, leg.u);
        leg.v = comparator(i.v - amplitude * carried.v, hysteresis, leg.v);
        leg.w = comparator(i.w - amplitude * carried.w, hysteresis, leg.w);
        const three_t v = {half_link * leg.u, half_link * leg.v, half_link * leg.w};
        three_t e = {k.u * shape.u, k.v * shape.v, k.w * shape.w};
        if (eccentric) {
            const double around = middle + w->eccentricity_phase;
            e.u *= 1.0 + w->eccentricity * cos(around);
            e.v *= 1.0 + w->eccentricity * cos(around - 2.0 * PI / 3.0);
            e.w *= 1.0 + w->eccentricity * cos(around + 2.0 * PI / 3.0);
        }
        const double free_w = v.w - e.w * speed - r.w * i.w;
        const double across_u = v.u - e.u * speed - r.u * i.u - free_w;
        const double across_v = v.v - e.v * speed - r.v * i.v - free_w;
        const double change_u = uu * across_u + uv * across_v, change_v = uv * across_u + vv * across_v;
        three_t mean = {i.u + 0.5 * change_u, i.v + 0.5 * change_v, 0.0};
        mean.w = -(mean.u + mean.v);
        i.u += change_u, i.v += change_v, i.w = -(i.u + i.v);

        const double now = dot(e, mean), real = mean.u - 0.5 * (mean.v + mean.w);
        const double imaginary = HALF_ROOT_OF_THREE * (mean.v - mean.w);
        quadrature += filter * (current_scale * dot(shown, mean) - quadrature);
        direct += filter * (current_scale * (-shown_cosine * real - shown_sine * imaginary) - direct);
        voltage += filter * (voltage_scale * dot(carried, v) - voltage);
        torque += now > limit ? limit : now < -limit ? -limit : now;
        air_gap_torque += now;
        link_energy += dot(v, mean) * h;
        loss_energy += (r.u * mean.u * mean.u + r.v * mean.v * mean.v + r.w * mean.w * mean.w) * h;
        angle += h * speed;
    }
    s->current = i, s->leg = leg, s->angle = angle;
    s->quadrature_current = quadrature, s->direct_current = direct, s->quadrature_voltage = voltage;
    s->torque = torque / steps, s->air_gap_torque = air_gap_torque / steps;
    s->link_energy = link_energy, s->loss_energy = loss_energy;
}
