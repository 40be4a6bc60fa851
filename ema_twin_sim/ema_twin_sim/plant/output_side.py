"""The output behind a measured motor, simulated between samples: its reaction torque and its motion.

Smooth as a search needs it: near standstill the sign of its friction fades, and its level yields over a short travel.
"""

import math
from collections import namedtuple

from numba import njit

from .driven_output import RESOLVED
from .driving_flank import ahead
from .friction import bristle_share, bristle_step
from .motion import MOTOR_ANGLE, SPEED
from .transmission import contact_torque, shaft_speed

_LONGEST, _SHORTEST = 1e-3, 5e-4  # s, bounds of a substep; in between it is short enough for the spring:
_PULL = 2.0 * math.pi * 5.0  # rad/s, rate at which an output is pulled to its measured position
_PHASE = 0.4  # rad, largest phase of a contact's oscillation per substep
_STIFFEST = 2.0 * math.pi * 250.0  # rad/s; a stiffer contact is replaced by one that samples resolve (driven_output.py)
_STIFF_TRAVEL = 5e-4  # rad of the fast shaft over which a stiff bristle yields
LOW_SPEED = 0.02  # rad/s, below which the sign of the speed fades: rows near standstill are not judged


@njit(error_model="numpy")
def sign(speed, fading):
    """-1 or 1, with a continuous transition below the speed ``fading`` [rad/s]; exact, and 0 at rest, if that is 0."""
    if math.fabs(speed) > fading:
        return 1.0 if speed > 0.0 else -1.0
    return speed / fading if fading > 0.0 else 0.0


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
        "pull",  # N m/rad: spring that pulls an output moving freely in the gap to its measured position; brake: damper
        "brake",
    ],
)
"""Constants that determine the output's motion behind a measured motor, as in ``layout.PLANT``."""


@njit(error_model="numpy")
def output_side(plant):
    """The output side of a plant; a contact too stiff for the samples is softened to what they resolve."""
    # an output driven through a gap often comes to rest: its friction is always a bristle, a stiff one if the model has
    # none, which suits a search better than a level that jumps
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
    """Initial position [rad, fast shaft] of an output behind a ``motion`` (n, 7).

    If it was measured (``seen`` (n,) [rad, slow shaft]), from the readings until contact is certain: a motor that has
    travelled through the whole backlash has made contact, where its lead was largest. If not measured, (0,), on the
    flank driven by the motor.
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
    """The longest step [s] for simulating an output side."""
    return min(_LONGEST, max(_SHORTEST, _PHASE / math.sqrt(side.stiffness / side.inertia)))


@njit(error_model="numpy", forceinline=True)
def output_step(
    side, h, gain, drag, compliance, motor_angle, motor_speed, angle, speed, bristle, load, drawn, seen, seen_speed
):
    """(transmitted torque [N m], angle [rad], speed [rad/s], bristle [rad]) of an output after a step ``h`` [s].

    ``gain`` and ``drag`` are its response, ``load`` [N m] opposes it. If ``drawn``, an output moving freely in the gap
    is pulled to its measured position ``seen`` [rad] with speed ``seen_speed`` [rad/s]. All at the fast shaft.
    """
    contact = contact_torque(
        motor_angle - angle, motor_speed - speed, side.stiffness, side.damping, side.gap, h, compliance
    )
    angle += 0.5 * h * speed
    one = 1.0 + side.asymmetry * sign(speed, LOW_SPEED)
    against = load + side.asymmetry * side.viscous * math.fabs(speed)
    bristle, bent = bristle_step(bristle, speed, side.dry * one, side.bristle_stiffness, side.bristle_damping, h)
    if drawn and contact == 0.0:
        against -= side.pull * (seen - angle) + side.brake * (seen_speed - speed)
    speed = shaft_speed(speed, contact - against - bent, 0.0, 0.0, gain, drag)
    angle += 0.5 * h * speed
    return contact, angle, speed, bristle
