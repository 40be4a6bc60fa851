"""Sliding windows over samples, mirrored beyond the ends.

Same results as scipy.ndimage to the last digit; importing that takes longer than reading six recordings.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view


def moving_maximum(values: np.ndarray, before: int, after: int) -> np.ndarray:
    """Maximum (n,) of the values (n,) from ``before`` samples before each to ``after`` samples after it."""
    maxima, count = np.pad(values, (before, after), mode="symmetric"), before + 1 + after
    width = 1  # window of the maxima so far, doubled as long as the full window is wider
    while 2 * width <= count:
        maxima = np.maximum(maxima[:-width], maxima[width:])
        width *= 2
    return np.maximum(maxima[: len(values)], maxima[count - width : count - width + len(values)])


def moving_median(values: np.ndarray, count: int) -> np.ndarray:
    """Median (n,) of the values (n,) over ``count`` samples (odd) around each."""
    padded = np.pad(values, count // 2, mode="symmetric")
    return np.sort(sliding_window_view(padded, count), axis=1)[:, count // 2]
