"""Readings that a sensor holds: a counter of few counts a turn, or a speed computed less often than it is logged.

Between two changes the error of such a reading stays as it is. Only a kernel that is wide beside them averages it, and
as if there were one sample in each.
"""

from __future__ import annotations

import math

import numpy as np


def samples_held(values: np.ndarray) -> float:
    """Samples (at least 1) for which a signal (n,) usually shows one reading, until it changes."""
    changes = np.flatnonzero(np.diff(values))
    return max(float(np.median(np.diff(changes))), 1.0) if len(changes) > 1 else 1.0


def noise_of_held(noise: float, values: np.ndarray) -> float:
    """Standard deviation of the white noise per sample that is as large, after a wide kernel, as a held ``noise``."""
    return noise * math.sqrt(samples_held(values))
