"""How fast a twin computes, relative to the time that it simulates. No ROS."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import TypeVar

_WINDOW = 1_000_000_000
"""Simulated time in ns over which the present pace is measured."""

Answer = TypeVar("Answer")


class Pace:
    """The computing time, for everything simulated and for the last simulated second."""

    def __init__(self, clock: Callable[[], int] = time.perf_counter_ns) -> None:
        """`clock` returns the time [ns]."""
        self._clock = clock
        self._steps: deque[tuple[int, int]] = deque()
        self._of_window = (0, 0)  # ns simulated, ns of computing; the next one too
        self._of_all = (0, 0)

    def timed(self, nanoseconds: int, compute: Callable[[], Answer]) -> Answer:
        """Call `compute`, which simulates this many ns, measure its time, and return its result."""
        begun = self._clock()
        answer = compute()
        self._add(nanoseconds, self._clock() - begun)
        return answer

    def _add(self, simulated: int, computing: int) -> None:
        self._steps.append((simulated, computing))
        self._of_all = self._of_all[0] + simulated, self._of_all[1] + computing
        self._of_window = self._of_window[0] + simulated, self._of_window[1] + computing
        while len(self._steps) > 1 and self._of_window[0] - self._steps[0][0] >= _WINDOW:
            first = self._steps.popleft()
            self._of_window = self._of_window[0] - first[0], self._of_window[1] - first[1]

    @property
    def now(self) -> float | None:
        """Simulated over computing time for the last simulated second; None before anything was simulated."""
        simulated, computing = self._of_window
        return simulated / computing if computing else None

    @property
    def overall(self) -> float | None:
        """The same for everything that was simulated."""
        simulated, computing = self._of_all
        return simulated / computing if computing else None

    @property
    def in_words(self) -> str | None:
        """`now` in words; None before anything was simulated."""
        return None if self.now is None else f"{self.now:.3g} × real time"

    @property
    def complaint(self) -> str:
        """A sentence on how far real time is missed and what would help; empty if real time is kept."""
        now = self.now
        if now is None or now >= 1.0:
            return ""
        return (
            f"needs {1.0 / now:.1f} s per second of bench time: this machine cannot run this model in real time; "
            "choose drive.kind averaged or transmission.kind two_inertia"
        )
