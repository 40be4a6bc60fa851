"""Messages lost on a topic, by the numbers that its publisher gives to its own."""

from __future__ import annotations

from collections.abc import Callable


class PublishedNumbers:
    """Follows the numbers of a topic's messages, which each publisher counts for itself.

    A message does not say whose it is: where several publish, what is lost is not known. A number that falls is of a
    publisher that began anew. What one sent before it was first heard is not counted: it may be older than the
    subscription.

    Attributes:
        known: whether losses are known.
    """

    def __init__(self, publishers: Callable[[], int]) -> None:
        """`publishers` tells how many publish now; it is asked only where a number does not follow the last."""
        self._publishers = publishers
        self._last: int | None = None
        self.known = True

    def lost_before(self, number: int | None) -> int:
        """How many messages went missing before this one; `number` None where the middleware gives none."""
        last, self._last = self._last, number
        if not self.known or last is None or number is None or number == last + 1:
            self.known = self.known and number is not None
            return 0
        if self._publishers() > 1:
            self.known = False
            return 0
        return max(0, number - last - 1)
