"""The mean square of a signal over its last seconds, batch by batch."""

from __future__ import annotations

import numpy as np


class RmsWindow:
    """Holds the samples of the last ``width`` seconds; values that are not finite do not count."""

    def __init__(self, width: float) -> None:
        self._width = width
        self._time, self._squares, self._good = np.zeros(0), np.zeros(0), np.zeros(0)

    def mean_squares(self, time: np.ndarray, values: np.ndarray) -> np.ndarray:
        """The mean square (n,) of the window that ends at each sample, at rising times [s] (n,); NaN without values.

        If a batch begins before samples that are held, as after a jump back in time, those samples are dropped.
        """
        held = self._time <= time[0] if len(time) else np.zeros(len(self._time), bool)
        times = np.concatenate([self._time[held], time])
        values = np.asarray(values, np.float64)
        finite = np.isfinite(values)
        squares = np.concatenate([self._squares[held], np.where(finite, values, 0.0) ** 2])
        good = np.concatenate([self._good[held], finite])
        sums, counts = (np.concatenate([[0.0], np.cumsum(each)]) for each in (squares, good))
        ends = np.arange(len(times) - len(time), len(times)) + 1
        firsts = np.searchsorted(times, time - self._width)
        number = counts[ends] - counts[firsts]
        means = np.maximum(sums[ends] - sums[firsts], 0.0) / np.where(number > 0.0, number, np.nan)
        kept = int(firsts[-1]) if len(firsts) else 0
        self._time, self._squares, self._good = times[kept:], squares[kept:], good[kept:]
        return means
