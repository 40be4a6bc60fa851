"""The noise of a single reading of a smooth signal, from the signal itself."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np


def reading_noise(values: np.ndarray) -> float:
    """Standard deviation of the white noise on a smooth signal (n,), by its third differences, robustly."""
    if len(values) < 4:
        return 0.0
    third = np.diff(values, 3)
    return float(1.4826 * np.median(np.abs(third - np.median(third))) / np.sqrt(20.0))


def polled_noise(values: np.ndarray) -> float:
    """The same of a sensor that may be polled faster than it updates, so that it repeats each reading.

    If most third differences are therefore zero, only readings that differ from the one before are used.
    """
    return reading_noise(values) or reading_noise(values[1:][np.diff(values) != 0.0])


def noise_at_points(values: np.ndarray, over: Sequence[np.ndarray]) -> float:
    """The same of values (n,) at operating points, whose rows may come in any order.

    ``over`` are what the values may depend on, (n,) each: in the order in which these rise, one within the other, the
    values are smoothest, and that tells least noise. Few levels of one thing may be equal: zero is no noise.
    """
    orders = [np.arange(len(values)), *(np.lexsort(keys) for keys in permutations(over))]
    shown = [noise for order in orders if (noise := reading_noise(values[order])) > 0.0]
    return min(shown, default=0.0)
