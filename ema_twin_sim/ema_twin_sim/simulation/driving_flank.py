"""Initial position of a twin's output in the backlash: ``plant/driving_flank.py`` for a plant's record."""

from __future__ import annotations

import numpy as np

from ..plant.driven_output import RESOLVED
from ..plant.driving_flank import ahead


def lead(plant: np.void, speed: float) -> float:
    """Lead [rad, fast shaft] of a motor with this ``speed`` [rad/s] over its output at the first sample.

    The plant is a record of ``layout.PLANT``.
    """
    return _lead(plant, speed, float(plant["contact_stiffness"]))


def begin_behind_measured_motion(state: np.void, plant: np.void, speed: float, position: float) -> None:
    """Let the output driven by the motor's measured motion (``plant.driven_output``) start on that flank, too.

    ``position`` [rad] is the motor's. At rest it starts with the first interval, in the middle of the gap.
    """
    before = _lead(plant, speed, min(plant["contact_stiffness"], plant["output_inertia"] * RESOLVED**2))
    if before != 0.0:
        state["driven_ready"] = 1.0
        state["driven_motor_angle"], state["driven_output_angle"] = position, position - before
        state["driven_motor_speed"] = state["driven_output_speed"] = speed


def _lead(plant: np.void, speed: float, stiffness: float) -> float:
    # plain Python: called once per run, so compiling would cost more than it saves
    friction = float(plant["output_dry"]), float(plant["output_viscous"])
    return float(ahead.py_func(float(plant["gap"]), *friction, stiffness, speed))
