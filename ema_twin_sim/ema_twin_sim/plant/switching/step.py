"""One step of the switching drive's electrical side: comparators, bridge, winding, torque, acquisition."""

import math

from ..compiled import compiled
from ..drive import limited
from .current_reference import block
from .electrical_angle import sine_and_cosine
from .inverter import comparator
from .measured import direct, filtered, in_quadrature, weighed
from .resolver import resolver_error
from .shapes import three_phases, three_trapezoids
from .windings import current_changes, eccentric


@compiled
def switching_step(
    constants,
    current_u,
    current_v,
    leg_u,
    leg_v,
    leg_w,
    quadrature_current,
    direct_current,
    quadrature_voltage,
    setpoint,
    angle,
    sine,
    cosine,
    speed,
):
    """Advance currents, legs and filters by one step, whose length is that of ``constants`` (``StepConstants``).

    The state: phase currents u and v [A] (w's is minus their sum), legs (1 or -1), filtered quadrature and direct
    current [A] and quadrature voltage [V]. The drive: ``setpoint`` [A] of the quadrature current. The motor, in the
    middle of the step: ``angle`` [rad], ``sine`` and ``cosine`` of pole pairs x angle (``electrical_angle.py``), and
    ``speed`` [rad/s]. The middle makes the back-EMF second order. The comparators see the currents at the start of the
    step, but use references at its middle, too, so that one sine serves all.

    Returns the state after the step in the same order, with w's current after v's; then, as means over the step, the
    shaft torque [N m] (limited to the motor's maximum, the thesis's BLDC.TMM), the air gap torque [N m] (not limited),
    the power [W] from the DC link and the power [W] lost in windings and switches. To rounding, power from the link =
    loss + air gap torque x speed + change of sum L i^2 / 2 over the step's length.
    """
    shown_angle, shown_sine, shown_cosine = angle, sine, cosine
    turns = constants.pole_pairs / (2.0 * math.pi)
    if constants.resolver_offset != 0.0 or constants.resolver_amplitude != 0.0:
        shown_angle = angle + resolver_error(constants, angle)
        shown_sine, shown_cosine = sine_and_cosine(turns * shown_angle)
    if constants.trapezoidal != 0.0:
        shape_u, shape_v, shape_w = three_trapezoids(turns * angle)
        shown_u, shown_v, shown_w = three_trapezoids(turns * shown_angle)
        carried_u, carried_v, carried_w = block(shown_u), block(shown_v), block(shown_w)
    else:
        shape_u, shape_v, shape_w = three_phases(sine, cosine)
        shown_u, shown_v, shown_w = three_phases(shown_sine, shown_cosine)
        carried_u, carried_v, carried_w = shown_u, shown_v, shown_w

    amplitude = constants.amplitude * setpoint
    leg_u = comparator(current_u, amplitude * carried_u, constants.hysteresis, leg_u)
    leg_v = comparator(current_v, amplitude * carried_v, constants.hysteresis, leg_v)
    leg_w = comparator(-(current_u + current_v), amplitude * carried_w, constants.hysteresis, leg_w)
    voltage_u = constants.half_link * leg_u
    voltage_v = constants.half_link * leg_v
    voltage_w = constants.half_link * leg_w

    emf_u = constants.emf_u * shape_u
    emf_v = constants.emf_v * shape_v
    emf_w = constants.emf_w * shape_w
    if constants.eccentricity != 0.0:
        factor_u, factor_v, factor_w = eccentric(constants, angle)
        emf_u *= factor_u
        emf_v *= factor_v
        emf_w *= factor_w
    change_u, change_v = current_changes(
        constants,
        current_u,
        current_v,
        voltage_u - emf_u * speed,
        voltage_v - emf_v * speed,
        voltage_w - emf_w * speed,
    )
    after_u = current_u + change_u
    after_v = current_v + change_v
    mean_u = current_u + 0.5 * change_u
    mean_v = current_v + 0.5 * change_v
    mean_w = -(mean_u + mean_v)

    air_gap_torque = weighed(emf_u, emf_v, emf_w, mean_u, mean_v, mean_w)
    power = weighed(voltage_u, voltage_v, voltage_w, mean_u, mean_v, mean_w)
    loss = weighed(
        constants.resistance_u * mean_u,
        constants.resistance_v * mean_v,
        constants.resistance_w * mean_w,
        mean_u,
        mean_v,
        mean_w,
    )
    if constants.trapezoidal != 0.0:
        quadrature = weighed(shown_u, shown_v, shown_w, mean_u, mean_v, mean_w)
        voltage = weighed(carried_u, carried_v, carried_w, voltage_u, voltage_v, voltage_w)
    else:
        quadrature = in_quadrature(shown_sine, shown_cosine, mean_u, mean_v, mean_w)
        voltage = in_quadrature(shown_sine, shown_cosine, voltage_u, voltage_v, voltage_w)
    along = direct(shown_sine, shown_cosine, mean_u, mean_v, mean_w)
    return (
        after_u,
        after_v,
        -(after_u + after_v),
        leg_u,
        leg_v,
        leg_w,
        filtered(quadrature_current, constants.current_scale * quadrature, constants.filter_gain),
        filtered(direct_current, constants.current_scale * along, constants.filter_gain),
        filtered(quadrature_voltage, constants.voltage_scale * voltage, constants.filter_gain),
        limited(air_gap_torque, constants.torque_limit),
        air_gap_torque,
        power,
        loss,
    )
