"""How long nothing has arrived, measured by a loop that may itself be held up. No ROS."""

from __future__ import annotations

from collections.abc import Hashable


class IdleTime:
    """The time in which a count did not change, for a caller that checks it now and then.

    A check adds `longest_look` [s] at most, however long ago the previous one was. While the process itself is held up
    (a kernel compiles, the machine is suspended) nothing can arrive, so that time says nothing about what is on its
    way. The first check adds nothing.
    """

    def __init__(self, longest_look: float) -> None:
        self._longest_look = longest_look
        self._count: Hashable = None
        self._looked: float | None = None
        self._idle = 0.0

    def look(self, count: Hashable, now: float) -> float:
        """The time [s] without a change up to `now` [s, a monotonic clock]; `count` is what has arrived by then."""
        if self._looked is None or count != self._count:
            self._idle = 0.0
        else:
            self._idle += min(now - self._looked, self._longest_look)
        self._count, self._looked = count, now
        return self._idle
