"""The rate that a replay reaches, compared with the requested one. No ROS."""

from __future__ import annotations

NEARLY = 0.95
"""Share of the requested rate that counts as reached: a report jitters by a few samples."""


class ReachedRate:
    """Rate, relative to real time, at which samples were sent between two calls, while playing."""

    def __init__(self, period: float) -> None:
        """``period`` [s] between two samples of the recording."""
        self._period = period
        self._last: tuple[int, int] | None = None

    def look(self, sent: int, now: int) -> float | None:
        """The rate since the last call, from the samples ``sent`` and the time ``now`` [ns]; None at the first call."""
        last, self._last = self._last, (sent, now)
        if last is None or now <= last[1]:
            return None
        return (sent - last[0]) * self._period / ((now - last[1]) * 1e-9)

    def pause(self) -> None:
        """Pause: the next call counts as the first one."""
        self._last = None


def rate_in_words(asked: float, reached: float | None) -> str:
    """The rate reached, and the one ``asked`` for (0: as fast as possible) if it is missed."""
    if asked == 0.0:
        return "as fast as it goes" if reached is None else f"{reached:.3g} × real time, as fast as it goes"
    if reached is None or reached >= NEARLY * asked:
        return f"{asked:g} × real time"
    return f"{reached:.2g} × real time, {asked:g} × was asked for: this machine or a reader is too slow"
