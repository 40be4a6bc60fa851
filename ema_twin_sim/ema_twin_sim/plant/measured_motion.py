"""The drive torque and the encoder reading that a model needs for a *measured* motion: its equation error.

At every sample the model's torques are taken at the measured operating point; nothing is integrated but what carries a
memory (the bristle of presliding friction; the output side behind play or a spring, driven by the measured motor). So a
wrong model does not drift away from the machine, and its error can be read sample by sample.
"""

import math

from numba import boolean, float64, from_dtype, int64, njit, types, void

from .driven_output import RESOLVED
from .evaluate import evaluate
from .friction import bristle_share, bristle_step
from .layout import DRY_LEVEL, PLANT, VISCOUS_COEFFICIENT
from .operating_point import OperatingPoint, call_effect
from .transmission import contact_torque, end_stop_torque, response, shaft_speed

MOTION = ("time", "motor_angle", "speed", "acceleration", "current", "output_angle", "load")
"""Columns of a measured motion: s, rad and rad/s and rad/s2 of the fast shaft, A, rad of the slow shaft, N m of a
measured load at the fast shaft; angles count from the recording's first sample."""
TIME, MOTOR_ANGLE, SPEED, ACCELERATION, MOTOR_CURRENT, OUTPUT_ANGLE, LOAD = range(7)

REQUIRED = ("torque", "output", "transmitted", "dry_level")
"""Columns of what a motion requires: torque [N m] but for the motor's own inertia, output angle [rad, slow shaft],
transmitted torque [N m], dry level [N m]."""

_EFFECTS = types.Tuple((int64[::1], int64[::1], float64[:, ::1]))
_PLANT = from_dtype(PLANT)
_LONGEST, _SHORTEST = 1e-3, 5e-4  # s of a substep; in between it is short enough for the spring:
_PULL = 2.0 * math.pi * 5.0  # rad/s with which an output is drawn to where it was seen
_MEETINGS = 500  # samples with touching teeth over which the encoder's zero is averaged
_PHASE = 0.4  # rad that a contact's oscillation may turn in a substep
_STIFFEST = 2.0 * math.pi * 250.0  # rad/s; a stiffer contact is taken as one that samples resolve (driven_output.py)
_STIFF_TRAVEL = 5e-4  # rad of the fast shaft over which a stiff bristle gives way
_LOW_SPEED = 0.02  # rad/s, below which the sign of the speed fades: rows near standstill are not judged


@njit(error_model="numpy")
def _sign(speed):
    size = math.fabs(speed)
    return (1.0 if speed > 0.0 else -1.0) if size > _LOW_SPEED else speed / _LOW_SPEED


@njit(error_model="numpy")
def _operating_point(plant, now, motor_origin, output_origin, transmitted, dry):
    """Where a measured motion ``now`` (a row of it) stands, beside a transmitted torque and a dry level [N m]."""
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


@njit(
    void(_PLANT[::1], _EFFECTS, float64[:, ::1], float64, float64, float64[::1], boolean, float64[:, ::1]),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def inverse_dynamics(plants, effects, motion, motor_origin, output_origin, seen, reuse_output_motion, required):
    """Fill ``required`` (n, 4) with the columns ``REQUIRED`` for a ``motion`` (n, 7) with the columns ``MOTION``.

    ``motor_origin`` and ``output_origin`` [rad] are the counters' own angles where the motion's are zero. An output
    that flies free between teeth is drawn to where it was ``seen`` (n,) [rad, slow shaft], unless that is empty.
    ``reuse_output_motion``: the output moves as ``required`` holds it already, and only what the motor's side asks for
    is new.
    """
    plant = plants[0]
    ratio = plant.gear_ratio
    rigid = plant.two_inertia == 0.0
    total_dry = plant.motor_dry + plant.output_dry
    viscous_total = plant.motor_viscous + plant.output_viscous
    stops = not (math.isinf(plant.end_stop_lower) and math.isinf(plant.end_stop_upper))
    bristle = output_bristle = 0.0
    bristled = plant.bristle_stiffness > 0.0
    share = 1.0 if rigid else bristle_share(plant)
    # an output that is driven through a gap comes to rest often: its friction is taken as a bristle always, a stiff one
    # where the model has none, which is kinder to a search than a level that jumps
    output_stiffness = plant.output_dry / _STIFF_TRAVEL
    output_damping = 0.5 * math.sqrt(output_stiffness * plant.output_inertia)
    if bristled:
        output_stiffness = plant.bristle_stiffness * (1.0 - share)
        output_damping = plant.bristle_damping * (1.0 - share)
    stiffness = plant.contact_stiffness
    damping = plant.contact_damping
    if stiffness > plant.output_inertia * _STIFFEST**2:
        stiffness = plant.output_inertia * RESOLVED**2
        damping = 2.0 * plant.output_inertia * RESOLVED
    substep = min(_LONGEST, max(_SHORTEST, _PHASE / math.sqrt(stiffness / plant.output_inertia)))
    output_angle = motion[0, MOTOR_ANGLE]
    output_speed = motion[0, SPEED]
    drawn = seen.shape[0] == motion.shape[0]
    zero = 0.0  # rad by which the output's encoder shows more, as seen while teeth touch
    met = 0
    pull = plant.output_inertia * _PULL * _PULL
    brake = 2.0 * plant.output_inertia * _PULL
    transmitted = 0.0
    for row in range(motion.shape[0]):
        speed = motion[row, SPEED]
        acceleration = motion[row, ACCELERATION]
        sense = _sign(speed)
        before = max(row - 1, 0)
        interval = motion[row, TIME] - motion[before, TIME]
        at = _operating_point(plant, motion[row], motor_origin, output_origin, transmitted, total_dry)
        torque, dry, load, thinned = evaluate(effects, at)
        load += motion[row, LOAD]
        if stops:
            angle = motion[row, OUTPUT_ANGLE]
            load += end_stop_torque(
                angle * ratio,
                speed,
                (plant.end_stop_lower - output_origin) * ratio,
                (plant.end_stop_upper - output_origin) * ratio,
                plant.contact_stiffness,
                plant.contact_damping,
            )
        if rigid:
            factor = 1.0 + plant.asymmetry * sense
            passed = plant.output_inertia * acceleration + plant.output_viscous * speed
            passed += plant.output_dry * sense + load
            viscous = viscous_total
            carried = load
        else:
            # the output alone, driven by the motor's measured motion
            factor = 1.0 + plant.asymmetry * sense
            viscous = plant.motor_viscous
            dry = max(0.0, dry - plant.output_dry)
            steps = max(1, math.ceil(interval / substep - 1e-9)) if row > 0 else 0
            passed = required[row, 2] if reuse_output_motion else transmitted
            if steps > 0 and not reuse_output_motion:
                h = interval / steps
                gain, drag = response(h, plant.output_inertia, plant.output_viscous)
                compliance = 0.5 * h / plant.output_inertia
                speed_before = motion[before, SPEED]
                slope = (speed - speed_before) / steps
                angle = motion[before, MOTOR_ANGLE]
                # the measured angle at both ends, the measured speed in between
                drift = motion[row, MOTOR_ANGLE] - angle - 0.5 * (speed + speed_before) * interval
                drift /= steps
                passed = 0.0
                seen_speed = (seen[row] - seen[before]) * ratio / interval if drawn else 0.0
                for k in range(steps):
                    motor_speed = speed_before + slope * (k + 0.5)
                    contact = contact_torque(
                        angle - output_angle,
                        motor_speed - output_speed,
                        stiffness,
                        damping,
                        plant.gap,
                        h,
                        compliance,
                    )
                    output_angle += 0.5 * h * output_speed
                    one = 1.0 + plant.asymmetry * _sign(output_speed)
                    against = load + plant.asymmetry * plant.output_viscous * math.fabs(output_speed)
                    output_bristle, bent = bristle_step(
                        output_bristle, output_speed, plant.output_dry * one, output_stiffness, output_damping, h
                    )
                    if met > 0 and contact == 0.0:
                        where = seen[before] * ratio - zero + (k + 0.5) * h * seen_speed
                        against -= pull * (where - output_angle) + brake * (seen_speed - output_speed)
                    output_speed = shaft_speed(output_speed, contact - against - bent, 0.0, 0.0, gain, drag)
                    output_angle += 0.5 * h * output_speed
                    angle += h * motor_speed + drift
                    passed += contact
                passed /= steps
                if drawn and contact != 0.0:
                    met += 1
                    zero += (seen[row] * ratio - output_angle - zero) / min(met, _MEETINGS)
            carried = 0.0  # added below
        dry_now = dry * factor
        torque += viscous * speed + plant.asymmetry * (viscous + thinned) * math.fabs(speed) + carried
        if bristled:
            bristle, bent = bristle_step(
                bristle,
                speed,
                dry_now,
                plant.bristle_stiffness * share,
                plant.bristle_damping * share,
                interval if interval > 0.0 else 1e-3,
            )
            torque += bent
        else:
            torque += dry_now * sense
        transmitted = passed
        required[row, 0] = torque
        if not reuse_output_motion:
            required[row, 1] = (motion[row, MOTOR_ANGLE] if rigid else output_angle) / ratio
        required[row, 2] = transmitted
        required[row, 3] = dry
    if not rigid:
        # what was passed in the intervals before and after a sample belongs half to it
        last = motion.shape[0] - 1
        for row in range(last + 1):
            required[row, 0] += 0.5 * (required[row, 2] + required[min(row + 1, last), 2])


@njit(
    void(_PLANT[::1], int64, int64, float64[::1], float64[:, ::1], float64, float64, float64[:, ::1], float64[::1]),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def inverse_dynamics_of(plants, address, place, p, motion, motor_origin, output_origin, required, torque):
    """``torque`` (n,): what one effect alone asks of the drive, beside all that ``required`` holds already.

    Right for a torque, a level or a coefficient of the motor's side while no bristle carries the level; ``p`` (4,).
    """
    plant = plants[0]
    values = (p[0], p[1], p[2], p[3])
    for row in range(motion.shape[0]):
        speed = motion[row, SPEED]
        transmitted = required[max(row - 1, 0), 2]
        at = _operating_point(plant, motion[row], motor_origin, output_origin, transmitted, required[row, 3])
        value = call_effect(address, at, values)
        sense = _sign(speed)
        if place == DRY_LEVEL:
            level = required[row, 3]
            value = (max(0.0, level + value) - level) * (sense + plant.asymmetry * sense * sense)
        elif place == VISCOUS_COEFFICIENT:
            value *= speed + plant.asymmetry * math.fabs(speed)
        torque[row] = value
