"""Where in its play an output stands at the first sample: on the driving flank where the motor moves, else unknown."""

from __future__ import annotations

import math

import numpy as np

from ..criteria import STANDSTILL
from ..plant.driven_output import RESOLVED


def lead(plant: np.void, speed: float) -> float:
    """By how much [rad of the fast shaft] a motor of this ``speed`` [rad/s] is ahead of its output at the first sample.

    One that moves drives the output along: teeth touch, and what the output's friction takes presses them. At rest, and
    without play, it is 0. The plant is a record of ``layout.PLANT``.
    """
    return _lead(plant, speed, float(plant["contact_stiffness"]))


def begin_behind_measured_motion(state: np.void, plant: np.void, speed: float, position: float) -> None:
    """Let the output that the motor's measured motion drives (``plant.driven_output``) begin on that flank too.

    ``position`` [rad] is the motor's. At rest it begins with the first interval, in the middle of the gap.
    """
    ahead = _lead(plant, speed, min(plant["contact_stiffness"], plant["output_inertia"] * RESOLVED**2))
    if ahead != 0.0:
        state["driven_ready"] = 1.0
        state["driven_motor_angle"], state["driven_output_angle"] = position, position - ahead
        state["driven_motor_speed"] = state["driven_output_speed"] = speed


def _lead(plant: np.void, speed: float, stiffness: float) -> float:
    if plant["gap"] == 0.0 or abs(speed) <= STANDSTILL:
        return 0.0
    pressed = (plant["output_dry"] + plant["output_viscous"] * abs(speed)) / stiffness
    return math.copysign(float(plant["gap"] + pressed), speed)
