"""Readings that a sensor holds: a counter of few counts a turn, or a speed computed less often than it is logged.

Between two changes the error of such a reading stays as it is. Only a kernel that is wide beside them averages it, and
as if there were one sample in each.
"""

from __future__ import annotations

import math

import numpy as np

from ..reading_noise import reading_noise
from .way_by_speed import FEWEST


def samples_held(values: np.ndarray) -> float:
    """Samples (at least 1) for which a signal (n,) usually shows one reading, until it changes."""
    changes = np.flatnonzero(np.diff(values))
    return float(np.median(np.diff(changes))) if len(changes) > 1 else 1.0


def noise_of_held(noise: float, values: np.ndarray) -> float:
    """Standard deviation of the white noise per sample that is as large, after a wide kernel, as a held ``noise``."""
    return noise * math.sqrt(samples_held(values))


def noise_of_readings(values: np.ndarray) -> float:
    """The same of a signal (n,) whose noise is not known, from the readings that differ from the one before.

    Third differences of samples see nothing of a noise that is held for longer. But a speed that changes now and then
    holds what it is, and no reading.
    """
    readings = values[np.r_[True, np.diff(values) != 0.0]]
    return noise_of_held(reading_noise(readings), values) if len(readings) > FEWEST else reading_noise(values)
