"""Whether the error of a twin grows: the slope of its RMSE from window to window. No ROS."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..criteria import APART, SMALL

_LEAST = 4
"""Number of windows that a slope with a standard error needs."""
_WINDOWS = 720
"""Number of windows that are kept: an hour of 5 s each."""
_TOLD = 20
"""Number of windows from which a slope is reported in words: with fewer, the standard error itself is uncertain."""


class Trend:
    """RMSE of successive whole windows, across runs; the slope by least squares."""

    def __init__(self, window: float) -> None:
        """`window` is the length of a window in s."""
        self._window = window
        self._errors: dict[str, _LastWindows] = {}
        self._slopes: dict[str, tuple[float, float]] = {}  # slope and its standard error
        self._next = window
        self._before = 0.0  # length in s of the finished runs
        self._in_run = 0.0

    def add(self, elapsed: float, rmse_window: Mapping[str, float]) -> None:
        """Take the RMSE of the last window, `elapsed` s after the run's first sample; most calls change nothing."""
        if elapsed < self._in_run:  # another run: its first window is whole after one window's length
            self._before += self._in_run
            self._next = self._window
        self._in_run = elapsed
        if elapsed < self._next:
            return
        self._next = elapsed + self._window
        for name, value in rmse_window.items():
            if math.isfinite(value):
                errors = self._errors.setdefault(name, _LastWindows())
                errors.add(self._before + elapsed, value)
                if errors.count >= _LEAST:
                    self._slopes[name] = _slope(*errors.held)

    def clear(self) -> None:
        """Begin again from scratch, because the twin has changed."""
        self._errors.clear()
        self._slopes.clear()
        self._next = self._in_run + self._window

    def slopes(self) -> dict[str, float]:
        """Slope of the RMSE per signal, in its unit per s; signals with fewer than four windows are left out."""
        return {name: slope for name, (slope, _) in self._slopes.items()}

    def growing(self) -> tuple[str, float] | None:
        """The signal whose error grows most, and its growth per hour as a share of its mean; None if none surely grows.

        The slope is tested after every window, and neighbouring windows are correlated. So it has to exceed `APART`
        times its standard error, and the growth over all windows `SMALL` times the mean.
        """
        shares = {}
        for name, (slope, std) in self._slopes.items():
            times, errors = self._errors[name].held
            mean, span = float(np.mean(errors)), float(times[-1] - times[0])
            if len(errors) >= _TOLD and slope > APART * std and slope * span > SMALL * mean:
                shares[name] = slope / mean * 3600.0
        return max(shares.items(), key=lambda item: item[1], default=None)


class _LastWindows:
    """Times [s] and errors of the last windows, in memory that is allocated once."""

    def __init__(self) -> None:
        self._rows = np.zeros((2, _WINDOWS))
        self.count = 0

    def add(self, time: float, error: float) -> None:
        """Add one; the oldest is dropped if the memory is full."""
        if self.count == _WINDOWS:
            self._rows[:, :-1] = self._rows[:, 1:]
            self.count -= 1
        self._rows[:, self.count] = time, error
        self.count += 1

    @property
    def held(self) -> tuple[np.ndarray, np.ndarray]:
        """Times and errors, the oldest first."""
        times, errors = self._rows[:, : self.count]
        return times, errors


def _slope(time: np.ndarray, value: np.ndarray) -> tuple[float, float]:
    """Slope by least squares, and its standard error."""
    time = time - time.mean()
    spread = float(time @ time)
    slope = float(time @ value) / spread
    left = value - value.mean() - slope * time
    return slope, math.sqrt(float(left @ left) / (len(time) - 2) / spread)
