"""Drive torque and encoder reading that a model needs for a *measured* motion: its equation error.

At every sample the model's torques are evaluated at the measured operating point. Only states with memory are
integrated (the bristle of presliding friction; the output side behind backlash or compliance, driven by the measured
motor). So a wrong model does not drift away from the machine, and its error is available sample by sample.
"""

import math

from numba import boolean, float64, int64, njit, void

from .evaluate import evaluate
from .friction import bristle_share, bristle_step
from .layout import DRY_LEVEL, VISCOUS_COEFFICIENT
from .motion import ACCELERATION, LOAD, MOTOR_ANGLE, MOTOR_CURRENT, OUTPUT_ANGLE, SPEED, TIME
from .operating_point import OperatingPoint, call_effect
from .output_side import first_output_angle, longest_substep, output_side, output_step, sign
from .signatures import EFFECTS, PLANTS, TABLE
from .time_steps import steps_in
from .transmission import end_stop_torque, response

REQUIRED = ("torque", "output", "transmitted", "dry_level")
"""Columns required for a motion: torque [N m] without the motor's own inertia, output angle [rad, slow shaft],
transmitted torque [N m], dry level [N m]."""
REQUIRED_TORQUE, REQUIRED_OUTPUT, REQUIRED_TRANSMITTED, REQUIRED_DRY = range(len(REQUIRED))

MEETINGS = 500  # samples with teeth in contact over which the encoder's zero is averaged


@njit(error_model="numpy", forceinline=True)
def with_friction(
    torque, carried, speed, sense, viscous, thinned, asymmetry, dry, bristled, bristle, stiffness, damping, interval
):
    """(torque [N m], bristle [rad]): drive torque for the effects' torque, the ``carried`` torque, and friction.

    ``sense`` is the direction of motion.
    """
    level = dry * (1.0 + asymmetry * sense)
    torque += viscous * speed + asymmetry * (viscous + thinned) * math.fabs(speed) + carried
    if not bristled:
        return torque + level * sense, bristle
    bristle, bent = bristle_step(bristle, speed, level, stiffness, damping, interval if interval > 0.0 else 1e-3)
    return torque + bent, bristle


@njit(error_model="numpy")
def base_dry_level(plant):
    """Dry level [N m] of the motor's side: with a rigid transmission, all of it.

    As the sum less the output's, since fits of impacts go with the last digit, and recorded figures are of that one.
    """
    total = plant.motor_dry + plant.output_dry
    return total if plant.two_inertia == 0.0 else total - plant.output_dry


@njit(error_model="numpy")
def operating_point(plant, now, motor_origin, output_origin, transmitted, dry):
    """Operating point of a measured motion's row ``now``, with a transmitted torque and a dry level [N m]."""
    return OperatingPoint(
        now[TIME],
        motor_origin + now[MOTOR_ANGLE],
        plant.pole_pairs * (motor_origin + now[MOTOR_ANGLE]),
        now[SPEED],
        output_origin + now[OUTPUT_ANGLE],
        now[OUTPUT_ANGLE],
        now[SPEED] / plant.gear_ratio,
        now[ACCELERATION],
        now[MOTOR_CURRENT],
        plant.torque_constant * now[MOTOR_CURRENT],
        transmitted,
        dry,
        plant.motor_viscous + plant.output_viscous,
    )


@njit(error_model="numpy")
def with_load(load, plant, now, output_origin):
    """The ``load`` [N m] of effects plus the measured load and the end stops at ``now``."""
    load += now[LOAD]
    if math.isinf(plant.end_stop_lower) and math.isinf(plant.end_stop_upper):
        return load
    ratio = plant.gear_ratio
    return load + end_stop_torque(
        now[OUTPUT_ANGLE] * ratio,
        now[SPEED],
        (plant.end_stop_lower - output_origin) * ratio,
        (plant.end_stop_upper - output_origin) * ratio,
        plant.contact_stiffness,
        plant.contact_damping,
    )


@njit(
    void(PLANTS, EFFECTS, TABLE, float64, float64, float64[::1], boolean, float64, TABLE),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def inverse_dynamics(plants, effects, motion, motor_origin, output_origin, seen, reuse_output_motion, fading, required):
    """Fill ``required`` (n, 4) with the columns ``REQUIRED`` for a ``motion`` (n, 7) with the columns ``MOTION``.

    ``motor_origin`` and ``output_origin`` [rad] are the counters' readings at position zero. An output that moves
    freely in the gap is pulled to its measured position ``seen`` (n,) [rad, slow shaft], unless that is empty; until
    the first contact it is at the measured position. ``reuse_output_motion``: use the output motion already in
    ``required``, and compute only the motor side. Below the speed ``fading`` [rad/s] the motion's direction fades
    (``LOW_SPEED``); operating points, which have no standstill between them, give 0.
    """
    plant = plants[0]
    ratio = plant.gear_ratio
    rigid = plant.two_inertia == 0.0
    base_dry = base_dry_level(plant)
    viscous_total = plant.motor_viscous + plant.output_viscous
    bristle = output_bristle = 0.0
    bristled = plant.bristle_stiffness > 0.0
    share = 1.0 if rigid else bristle_share(plant)
    side = output_side(plant)
    substep = longest_substep(side)
    output_angle = first_output_angle(side, motion, ratio, seen)
    output_speed = motion[0, SPEED]
    drawn = seen.shape[0] == motion.shape[0]
    zero = 0.0  # rad, offset of the output's encoder, estimated while teeth are in contact
    met = first_met = 0
    transmitted = 0.0
    for row in range(motion.shape[0]):
        speed = motion[row, SPEED]
        acceleration = motion[row, ACCELERATION]
        sense = sign(speed, fading)
        before = max(row - 1, 0)
        interval = motion[row, TIME] - motion[before, TIME]
        at = operating_point(plant, motion[row], motor_origin, output_origin, transmitted, base_dry)
        torque, dry, load, thinned = evaluate(effects, at)
        load = with_load(load, plant, motion[row], output_origin)
        if rigid:
            passed = plant.output_inertia * acceleration + plant.output_viscous * speed
            passed += plant.output_dry * sense + load
            viscous = viscous_total
            carried = load
        else:
            # the output alone, driven by the motor's measured motion
            viscous = plant.motor_viscous
            steps = steps_in(interval, substep) if row > 0 else 0
            passed = required[row, REQUIRED_TRANSMITTED] if reuse_output_motion else transmitted
            if steps > 0 and not reuse_output_motion:
                h = interval / steps
                gain, drag = response(h, side.inertia, side.viscous)
                compliance = 0.5 * h / side.inertia
                speed_before = motion[before, SPEED]
                slope = (speed - speed_before) / steps
                angle = motion[before, MOTOR_ANGLE]
                # measured angle at both ends, measured speed in between
                drift = motion[row, MOTOR_ANGLE] - angle - 0.5 * (speed + speed_before) * interval
                drift /= steps
                passed = 0.0
                seen_speed = (seen[row] - seen[before]) * ratio / interval if drawn else 0.0
                for k in range(steps):
                    motor_speed = speed_before + slope * (k + 0.5)
                    where = seen[before] * ratio - zero + (k + 0.5) * h * seen_speed if met > 0 else 0.0
                    contact, output_angle, output_speed, output_bristle = output_step(
                        side, h, gain, drag, compliance, angle, motor_speed, output_angle, output_speed, output_bristle,
                        load, met > 0, where, seen_speed,
                    )  # fmt: skip
                    angle += h * motor_speed + drift
                    passed += contact
                passed /= steps
                if drawn and contact != 0.0:
                    first_met = row if met == 0 else first_met
                    met += 1
                    zero += (seen[row] * ratio - output_angle - zero) / min(met, MEETINGS)
            carried = 0.0  # added below
        torque, bristle = with_friction(
            torque, carried, speed, sense, viscous, thinned, plant.asymmetry, dry, bristled, bristle,
            plant.bristle_stiffness * share, plant.bristle_damping * share, interval,
        )  # fmt: skip
        transmitted = passed
        required[row, REQUIRED_TORQUE] = torque
        if not reuse_output_motion:
            required[row, REQUIRED_OUTPUT] = (motion[row, MOTOR_ANGLE] if rigid else output_angle) / ratio
        required[row, REQUIRED_TRANSMITTED] = transmitted
        required[row, REQUIRED_DRY] = dry
    if not reuse_output_motion:
        for row in range(first_met):
            required[row, REQUIRED_OUTPUT] = seen[row] - zero / ratio
    if not rigid:
        # a sample gets half of the torque transmitted in the intervals before and after it
        last = motion.shape[0] - 1
        for row in range(last + 1):
            required[row, REQUIRED_TORQUE] += 0.5 * (
                required[row, REQUIRED_TRANSMITTED] + required[min(row + 1, last), REQUIRED_TRANSMITTED]
            )


@njit(
    float64(PLANTS, int64, int64, float64[::1], TABLE, float64, float64, float64, TABLE, float64[::1]),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def inverse_dynamics_of(plants, address, place, p, motion, motor_origin, output_origin, fading, required, torque):
    """``torque`` (n,): drive torque needed by one effect alone, in addition to what ``required`` already holds.

    Valid for a torque, a level or a coefficient of the motor side if no bristle carries the level; ``p`` (4,);
    ``fading`` [rad/s] as there. Returns the smallest value of the effect, before the sense of motion gives it a sign.
    """
    least = math.inf
    plant = plants[0]
    values = (p[0], p[1], p[2], p[3])
    for row in range(motion.shape[0]):
        speed = motion[row, SPEED]
        transmitted = required[max(row - 1, 0), REQUIRED_TRANSMITTED]
        at = operating_point(plant, motion[row], motor_origin, output_origin, transmitted, required[row, REQUIRED_DRY])
        value = call_effect(address, at, values)
        least = min(least, value)
        sense = sign(speed, fading)
        if place == DRY_LEVEL:
            value = max(value, -required[row, REQUIRED_DRY])  # a level is cut off at zero
            value *= sense + plant.asymmetry * sense * sense
        elif place == VISCOUS_COEFFICIENT:
            value *= speed + plant.asymmetry * math.fabs(speed)
        torque[row] = value
    return least
