"""How fast a twin computes, beside the time that it simulates. No ROS."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import TypeVar

_WINDOW = 1_000_000_000
"""ns of simulated time that the present pace is taken over."""

Answer = TypeVar("Answer")


class Pace:
    """The time that computing takes, over all that was simulated and over the last second of it."""

    def __init__(self, clock: Callable[[], int] = time.perf_counter_ns) -> None:
        """`clock` tells the time [ns]."""
        self._clock = clock
        self._steps: deque[tuple[int, int]] = deque()
        self._simulated = self._computing = 0
        self._all_simulated = self._all_computing = 0

    def timed(self, nanoseconds: int, compute: Callable[[], Answer]) -> Answer:
        """What `compute` returns, which simulates this much [ns]."""
        begun = self._clock()
        answer = compute()
        self._add(nanoseconds, self._clock() - begun)
        return answer

    def _add(self, simulated: int, computing: int) -> None:
        self._steps.append((simulated, computing))
        self._simulated += simulated
        self._computing += computing
        self._all_simulated += simulated
        self._all_computing += computing
        while self._simulated - self._steps[0][0] >= _WINDOW:
            first = self._steps.popleft()
            self._simulated -= first[0]
            self._computing -= first[1]

    @property
    def now(self) -> float | None:
        """Simulated over computing time, of the last second simulated; None before anything was."""
        return self._simulated / self._computing if self._computing else None

    @property
    def overall(self) -> float | None:
        """The same of everything that was simulated."""
        return self._all_simulated / self._all_computing if self._all_computing else None

    @property
    def complaint(self) -> str:
        """That, and by how much, real time is not kept; empty where it is."""
        now = self.now
        if now is None or now >= 1.0:
            return ""
        return f"takes {1.0 / now:.1f} s for a second of the bench: {REMEDY}"


REMEDY = "this machine cannot run this model in real time; choose drive.kind averaged or transmission.kind two_inertia"
