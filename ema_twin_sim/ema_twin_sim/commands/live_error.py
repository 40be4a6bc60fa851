"""The error of a live run, printed line by line while it runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from ema_bench_replay.recording import Recording

from ..nodes.live_session import Pair
from ..quantities import quantity
from ..simulation.compared_signals import UNITS
from .output import console
from .tables import is_narrow

_WINDOW = 1.0  # s that each printed error covers
_BY_CURRENT = "unexplained_torque"
_BY_SETPOINT = ("output_position", "current", "speed")
"""The signals whose error is printed, by what drives the twin."""
LINES_ARE = "  error: the RMSE of each second; 17× means 17 times the sensors' noise"
"""Explains the lines of ``ErrorPrinter``; printed before the first of them."""


class ErrorPrinter:
    """Prints the error about once per second of the run, and passes batches of pairs on to its watchers.

    If the current drives the twin, the current has no error and the positions drift: the unexplained torque is printed.
    Otherwise the errors of output position, current and speed are.
    """

    def __init__(self, noise: Mapping[str, float], recording: Recording | None) -> None:
        """``noise`` holds the noise floor of each signal."""
        self.watchers: list[Callable[[Sequence[Pair]], None]] = []
        self._floors = noise
        self._duration = recording.duration if recording is not None else None
        self._first: int | None = None
        self._last = 0
        self._next = 0.0
        self._sums: dict[str, list[float]] = {}

    def take(self, pairs: Sequence[Pair]) -> None:
        """Take a batch of pairs from the running monitor."""
        for pair in pairs:
            if self._first is None or pair.stamp <= self._last:  # another run
                self._first, self._next = pair.stamp, _WINDOW
                self._sums.clear()
            self._last = pair.stamp
            for name in (_BY_CURRENT, *_BY_SETPOINT):
                residual = pair.residuals.get(name, float("nan"))
                if residual == residual:
                    held = self._sums.setdefault(name, [0.0, 0.0])
                    held[0] += residual * residual
                    held[1] += 1.0
            elapsed = (pair.stamp - self._first) * 1e-9
            if elapsed >= self._next:
                self._print(elapsed)
                self._next = elapsed + _WINDOW
        for watcher in self.watchers:
            watcher(pairs)

    @property
    def _by_current(self) -> bool:
        """Whether the current drives the twin, judged by its residual, which is then exactly 0.

        Also true if no residual of the other signals has arrived.
        """
        square, _ = self._sums.get("current", (math.nan, 0.0))
        return square == 0.0 or not any(name in self._sums for name in _BY_SETPOINT)

    def _print(self, elapsed: float) -> None:
        of = f" of {self._duration:.0f}" if self._duration else ""
        parts = []
        for name in (_BY_CURRENT,) if self._by_current else _BY_SETPOINT:
            square, count = self._sums.get(name, (0.0, 0.0))
            if not count:
                continue
            rmse = (square / count) ** 0.5
            label = (name.removeprefix("output_") if is_narrow() else name).replace("_", " ")
            floor = self._floors[name]  # 0 if the sensor's noise is unknown
            times = f" {rmse / floor:5.0f}×" if floor > 0.0 else ""
            parts.append(f"{label} {quantity(rmse, UNITS[name]):>9}{times}")
        line = f" {elapsed:5.1f}{of} s  error  " + "  ".join(parts)
        console.print(line, highlight=False, soft_wrap=True)
        self._sums.clear()
