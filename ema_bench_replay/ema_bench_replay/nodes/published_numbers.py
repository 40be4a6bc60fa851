"""Count messages lost on a topic, from the sequence numbers of its publisher."""

from __future__ import annotations

from collections.abc import Callable


class PublishedNumbers:
    """Tracks the sequence numbers of a topic's messages, which each publisher counts separately.

    A message does not identify its publisher: with several publishers, losses are unknown. A falling number means that
    the publisher restarted. Messages sent before the first one received are not counted: they may be older than the
    subscription.

    Attributes:
        known: whether losses are known.
    """

    def __init__(self, publishers: Callable[[], int]) -> None:
        """`publishers` returns the present number of publishers; it is called only if a number does not follow."""
        self._publishers = publishers
        self._last: int | None = None
        self.known = True

    def lost_before(self, number: int | None) -> int:
        """Number of messages missing before this one; `number` is None if the middleware gives none."""
        last, self._last = self._last, number
        if not self.known or last is None or number is None or number == last + 1:
            self.known = self.known and number is not None
            return 0
        if self._publishers() > 1:
            self.known = False
            return 0
        return max(0, number - last - 1)
