"""Periodic deadlines that do not drift. No ROS: the caller passes the time."""

from __future__ import annotations


class DeadlineClock:
    """Deadlines at whole periods after a start time, on a monotonic clock [ns].

    They are absolute: a late period does not shift those after it. If the caller comes so late that whole periods have
    passed, these are counted as missed and not made up for. A timer with this period may fire a little early: it is
    served, otherwise it would be a whole period late the next time.

    Attributes:
        missed: periods missed.
        worst: the longest delay after a deadline [ns].
    """

    def __init__(self, period: int, now: int) -> None:
        """Periods of `period` ns; the first deadline is `now`."""
        self._period = period
        self._origin = now
        self._next = 0
        self.missed = 0
        self.worst = 0

    def tick(self, now: int) -> int | None:
        """The number of the period that has begun, from 0; None if the next is half a period ahead or more."""
        late = now - self._origin - self._next * self._period
        if late <= -(self._period // 2):
            return None
        self.worst = max(self.worst, late)
        missed = max(late, 0) // self._period
        self.missed += missed
        number = self._next + missed
        self._next = number + 1
        return number
