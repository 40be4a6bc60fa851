"""The voltage that a motor induces as it turns, beside what a drive has: torque constants that no motor can have.

A motor of k N m/A (k N/A) induces k V s/rad (k V s/m).
"""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import NEARLY_ALL, TOO_MUCH
from ..model import Model
from ..model.check_comment import is_assumed
from ..model.matching import BY_TORQUE
from ..model.model_file import ABSENT, TORQUE_CONSTANT
from ..model.own_units import shown
from .way_by_speed import lag_of

BUS = 600.0
"""V that a motor may induce: about the DC link of a drive at a mains of 400 V, as most servo drives are (565 V,
rectified). Drives of small motors and robots have 24 to 325 V."""


def impossible_voltage(recording: Recording, model: Model) -> float | None:
    """The voltage [V] that the model's torque constant would induce at the recorded speed, if it is far beyond ``BUS``.

    None if it is not, and where no torque constant is known or none counts: it is open or assumed, or a torque was
    recorded. Recording and model are in the machine's own units.
    """
    constant = model.constants[TORQUE_CONSTANT]
    unknown = constant.source == ABSENT or is_assumed(constant.source) or math.isinf(constant.tolerance)
    if unknown or not recording.has("current") or BY_TORQUE in recording.metadata:
        return None
    voltage, _ = shown(model, model.value(TORQUE_CONSTANT) * _top_speed(recording), "V")
    return voltage if voltage > TOO_MUCH * BUS else None


def _top_speed(recording: Recording) -> float:
    """A speed [rad/s] that a recording exceeds only now and then; 0 if none is known.

    It is the measured one, or the mean over as many samples as displacements are compared over. Operating points may
    come in any order: their positions tell no speed.
    """
    if recording.has("speed"):
        speeds = recording.signals["speed"]
    elif recording.of_points or not recording.has("motor_position"):
        return 0.0
    else:
        lag = lag_of(recording)
        position, time = recording.signals["motor_position"], recording.time
        speeds = (position[lag:] - position[:-lag]) / (time[lag:] - time[:-lag])
    known = np.abs(speeds[np.isfinite(speeds)])
    return float(np.quantile(known, NEARLY_ALL)) if len(known) else 0.0
