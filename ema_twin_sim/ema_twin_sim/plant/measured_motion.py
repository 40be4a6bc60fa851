"""The drive torque and the encoder reading that a model needs for a *measured* motion: its equation error.

At every sample the model's torques are taken at the measured operating point; nothing is integrated but what carries a
memory (the bristle of presliding friction; the output side behind play or a spring, driven by the measured motor). So a
wrong model does not drift away from the machine, and its error can be read sample by sample.
"""

import math
from collections import namedtuple

from numba import boolean, float64, from_dtype, int64, njit, types, void

from .driven_output import RESOLVED
from .driving_flank import ahead
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
MEETINGS = 500  # samples with touching teeth over which the encoder's zero is averaged
_PHASE = 0.4  # rad that a contact's oscillation may turn in a substep
_STIFFEST = 2.0 * math.pi * 250.0  # rad/s; a stiffer contact is taken as one that samples resolve (driven_output.py)
_STIFF_TRAVEL = 5e-4  # rad of the fast shaft over which a stiff bristle gives way
_LOW_SPEED = 0.02  # rad/s, below which the sign of the speed fades: rows near standstill are not judged


OutputSide = namedtuple(
    "OutputSide",
    [
        "inertia",
        "viscous",
        "dry",
        "gap",
        "asymmetry",
        "stiffness",
        "damping",
        "bristle_stiffness",
        "bristle_damping",
        "pull",  # with which an output that flies free is drawn to where it was seen, and braked
        "brake",
    ],
)
"""What the output's motion behind a measured motor depends on, as ``layout.PLANT`` has it."""


@njit(error_model="numpy")
def output_side(plant):
    """The output side of a plant; a contact that samples do not resolve is one that they do."""
    # an output that is driven through a gap comes to rest often: its friction is taken as a bristle always, a stiff one
    # where the model has none, which is kinder to a search than a level that jumps
    bristle_stiffness = plant.output_dry / _STIFF_TRAVEL
    bristle_damping = 0.5 * math.sqrt(bristle_stiffness * plant.output_inertia)
    if plant.bristle_stiffness > 0.0:
        share = 1.0 if plant.two_inertia == 0.0 else bristle_share(plant)
        bristle_stiffness = plant.bristle_stiffness * (1.0 - share)
        bristle_damping = plant.bristle_damping * (1.0 - share)
    stiffness = plant.contact_stiffness
    damping = plant.contact_damping
    if stiffness > plant.output_inertia * _STIFFEST**2:
        stiffness = plant.output_inertia * RESOLVED**2
        damping = 2.0 * plant.output_inertia * RESOLVED
    return OutputSide(
        plant.output_inertia,
        plant.output_viscous,
        plant.output_dry,
        plant.gap,
        plant.asymmetry,
        stiffness,
        damping,
        bristle_stiffness,
        bristle_damping,
        plant.output_inertia * _PULL * _PULL,
        2.0 * plant.output_inertia * _PULL,
    )


@njit(error_model="numpy")
def first_output_angle(side, motion, ratio, seen):
    """Where an output begins [rad, fast shaft] behind a ``motion`` (n, 7).

    Where it was ``seen`` (n,) [rad, slow shaft]: what that shows since then until its teeth are sure to touch. A motor
    that went all through the play has met them, and was the farthest ahead as it did. Not seen, (0,), on the flank
    that its motor drives.
    """
    begun = motion[0, MOTOR_ANGLE]
    if side.gap > 0.0 and seen.shape[0] == motion.shape[0]:
        lowest = highest = begun
        least = most = 0.0
        for row in range(motion.shape[0]):
            angle = motion[row, MOTOR_ANGLE]
            lead = angle - begun - (seen[row] - seen[0]) * ratio
            least, most = min(least, lead), max(most, lead)
            lowest, highest = min(lowest, angle), max(highest, angle)
            touching = side.gap + (side.dry + side.viscous * math.fabs(motion[row, SPEED])) / side.stiffness
            if angle - lowest > 2.0 * side.gap:
                return begun - max(touching - most, -touching)
            if highest - angle > 2.0 * side.gap:
                return begun + max(touching + least, -touching)
    return begun - ahead(side.gap, side.dry, side.viscous, side.stiffness, motion[0, SPEED])


@njit(error_model="numpy")
def longest_substep(side):
    """The longest step [s] in which an output side is simulated."""
    return min(_LONGEST, max(_SHORTEST, _PHASE / math.sqrt(side.stiffness / side.inertia)))


@njit(error_model="numpy", forceinline=True)
def output_step(
    side, h, gain, drag, compliance, motor_angle, motor_speed, angle, speed, bristle, load, drawn, seen, seen_speed
):
    """(torque [N m] passed on, angle [rad], speed [rad/s], bristle [rad]) of an output after a step ``h`` [s].

    ``gain`` and ``drag`` are its response, ``load`` [N m] stands against it. An output that flies free is ``drawn`` to
    where it was ``seen`` [rad], whose speed is ``seen_speed`` [rad/s]. All is at the fast shaft.
    """
    contact = contact_torque(
        motor_angle - angle, motor_speed - speed, side.stiffness, side.damping, side.gap, h, compliance
    )
    angle += 0.5 * h * speed
    one = 1.0 + side.asymmetry * sign(speed)
    against = load + side.asymmetry * side.viscous * math.fabs(speed)
    bristle, bent = bristle_step(bristle, speed, side.dry * one, side.bristle_stiffness, side.bristle_damping, h)
    if drawn and contact == 0.0:
        against -= side.pull * (seen - angle) + side.brake * (seen_speed - speed)
    speed = shaft_speed(speed, contact - against - bent, 0.0, 0.0, gain, drag)
    angle += 0.5 * h * speed
    return contact, angle, speed, bristle


@njit(error_model="numpy", forceinline=True)
def with_friction(
    torque, carried, speed, viscous, thinned, asymmetry, dry, bristled, bristle, stiffness, damping, interval
):
    """(torque [N m], bristle [rad]): what a drive gives for its effects' torque and what is ``carried`` on, and for its
    friction.
    """
    sense = sign(speed)
    level = dry * (1.0 + asymmetry * sense)
    torque += viscous * speed + asymmetry * (viscous + thinned) * math.fabs(speed) + carried
    if not bristled:
        return torque + level * sense, bristle
    bristle, bent = bristle_step(bristle, speed, level, stiffness, damping, interval if interval > 0.0 else 1e-3)
    return torque + bent, bristle


@njit(error_model="numpy")
def sign(speed):
    """-1 or 1, and in between near standstill."""
    size = math.fabs(speed)
    return (1.0 if speed > 0.0 else -1.0) if size > _LOW_SPEED else speed / _LOW_SPEED


@njit(error_model="numpy")
def operating_point(plant, now, motor_origin, output_origin, transmitted, dry):
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


@njit(error_model="numpy")
def with_load(load, plant, now, output_origin):
    """The ``load`` [N m] of effects with what was measured and the end stops put against the output, at ``now``."""
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
    void(_PLANT[::1], _EFFECTS, float64[:, ::1], float64, float64, float64[::1], boolean, float64[:, ::1]),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def inverse_dynamics(plants, effects, motion, motor_origin, output_origin, seen, reuse_output_motion, required):
    """Fill ``required`` (n, 4) with the columns ``REQUIRED`` for a ``motion`` (n, 7) with the columns ``MOTION``.

    ``motor_origin`` and ``output_origin`` [rad] are the counters' own angles where the motion's are zero. An output
    that flies free between teeth is drawn to where it was ``seen`` (n,) [rad, slow shaft], unless that is empty; until
    it first meets them it is where it was seen.
    ``reuse_output_motion``: the output moves as ``required`` holds it already, and only what the motor's side asks for
    is new.
    """
    plant = plants[0]
    ratio = plant.gear_ratio
    rigid = plant.two_inertia == 0.0
    total_dry = plant.motor_dry + plant.output_dry
    viscous_total = plant.motor_viscous + plant.output_viscous
    bristle = output_bristle = 0.0
    bristled = plant.bristle_stiffness > 0.0
    share = 1.0 if rigid else bristle_share(plant)
    side = output_side(plant)
    substep = longest_substep(side)
    output_angle = first_output_angle(side, motion, ratio, seen)
    output_speed = motion[0, SPEED]
    drawn = seen.shape[0] == motion.shape[0]
    zero = 0.0  # rad by which the output's encoder shows more, as seen while teeth touch
    met = first_met = 0
    transmitted = 0.0
    for row in range(motion.shape[0]):
        speed = motion[row, SPEED]
        acceleration = motion[row, ACCELERATION]
        sense = sign(speed)
        before = max(row - 1, 0)
        interval = motion[row, TIME] - motion[before, TIME]
        at = operating_point(plant, motion[row], motor_origin, output_origin, transmitted, total_dry)
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
            dry = max(0.0, dry - plant.output_dry)
            steps = max(1, math.ceil(interval / substep - 1e-9)) if row > 0 else 0
            passed = required[row, 2] if reuse_output_motion else transmitted
            if steps > 0 and not reuse_output_motion:
                h = interval / steps
                gain, drag = response(h, side.inertia, side.viscous)
                compliance = 0.5 * h / side.inertia
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
            torque, carried, speed, viscous, thinned, plant.asymmetry, dry, bristled, bristle,
            plant.bristle_stiffness * share, plant.bristle_damping * share, interval,
        )  # fmt: skip
        transmitted = passed
        required[row, 0] = torque
        if not reuse_output_motion:
            required[row, 1] = (motion[row, MOTOR_ANGLE] if rigid else output_angle) / ratio
        required[row, 2] = transmitted
        required[row, 3] = dry
    if not reuse_output_motion:
        for row in range(first_met):
            required[row, 1] = seen[row] - zero / ratio
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
        at = operating_point(plant, motion[row], motor_origin, output_origin, transmitted, required[row, 3])
        value = call_effect(address, at, values)
        sense = sign(speed)
        if place == DRY_LEVEL:
            level = required[row, 3]
            value = (max(0.0, level + value) - level) * (sense + plant.asymmetry * sense * sense)
        elif place == VISCOUS_COEFFICIENT:
            value *= speed + plant.asymmetry * math.fabs(speed)
        torque[row] = value
