"""How long nothing has arrived, as told by a loop that may itself stand still. No ROS."""

from __future__ import annotations

from collections.abc import Hashable


class IdleTime:
    """The time in which a count did not change, for a caller that looks at it now and then.

    A look counts `longest_look` [s] at most, however long ago the look before was. While the process itself stood still
    (a kernel compiles, the machine is suspended) nothing could arrive, so that time says nothing about what is on its
    way. The first look counts nothing.
    """

    def __init__(self, longest_look: float) -> None:
        self._longest_look = longest_look
        self._count: Hashable = None
        self._looked: float | None = None
        self._idle = 0.0

    def look(self, count: Hashable, now: float) -> float:
        """The time [s] without a change up to `now` [s, a monotonic clock], at which `count` is what has arrived."""
        if self._looked is None or count != self._count:
            self._idle = 0.0
        else:
            self._idle += min(now - self._looked, self._longest_look)
        self._count, self._looked = count, now
        return self._idle
