"""Windows that slide over samples; where one reaches beyond an end, the samples stand there mirrored.

As scipy.ndimage has them, to the last digit, whose import takes longer than to read six recordings.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view


def moving_maximum(values: np.ndarray, before: int, after: int) -> np.ndarray:
    """The largest (n,) of the values (n,) from so many samples ``before`` each to so many ``after`` it."""
    maxima, count = np.pad(values, (before, after), mode="symmetric"), before + 1 + after
    width = 1  # over which the maxima are: doubled, as long as the window is wider
    while 2 * width <= count:
        maxima = np.maximum(maxima[:-width], maxima[width:])
        width *= 2
    return np.maximum(maxima[: len(values)], maxima[count - width : count - width + len(values)])


def moving_median(values: np.ndarray, count: int) -> np.ndarray:
    """The median (n,) of the values (n,) over ``count`` samples, an odd number, about each."""
    padded = np.pad(values, count // 2, mode="symmetric")
    return np.sort(sliding_window_view(padded, count), axis=1)[:, count // 2]
