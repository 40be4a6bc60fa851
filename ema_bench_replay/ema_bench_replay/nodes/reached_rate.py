"""The rate that a replay reaches, beside the one it was asked for. No ROS."""

from __future__ import annotations

NEARLY = 0.95
"""Of the rate asked for: what a report's own jitter of a few samples leaves of it."""


class ReachedRate:
    """Times real time at which samples were sent between two looks, while playing."""

    def __init__(self, period: float) -> None:
        """``period`` [s] between two samples of the recording."""
        self._period = period
        self._last: tuple[int, int] | None = None

    def look(self, sent: int, now: int) -> float | None:
        """The rate since the last look, by the samples ``sent`` and the time ``now`` [ns]; None at the first one."""
        last, self._last = self._last, (sent, now)
        if last is None or now <= last[1]:
            return None
        return (sent - last[0]) * self._period / ((now - last[1]) * 1e-9)

    def pause(self) -> None:
        """Nothing is to be sent: the next look is a first one."""
        self._last = None


def rate_in_words(asked: float, reached: float | None) -> str:
    """The rate of playing: the one reached, and the one ``asked`` for (0: as fast as it goes) where it is missed."""
    if asked == 0.0:
        return "as fast as it goes" if reached is None else f"{reached:.3g} × real time, as fast as it goes"
    if reached is None or reached >= NEARLY * asked:
        return f"{asked:g} × real time"
    return f"{reached:.2g} × real time, {asked:g} × was asked for: this machine or a reader is too slow"
