"""Messages lost on a topic, by the numbers that each publisher gives to its own."""

from __future__ import annotations

from collections.abc import Callable


class PublishedNumbers:
    """Follows the numbers of a topic's messages. A message does not say whose it is; its number mostly does.

    A number continues the publisher that gave the one before. One that continues none begins a publisher that was not
    heard before; where all have been heard, it has left a gap behind the nearest that is lower. What a publisher sent
    before it was first heard is not counted: it may be older than the subscription.
    """

    def __init__(self, publishers: Callable[[], int]) -> None:
        """`publishers` tells how many publish now; it is asked only where a number continues none."""
        self._publishers = publishers
        self._last: set[int] = set()  # number given last, of each publisher

    def lost_before(self, number: int) -> int:
        """How many messages went missing before this one."""
        nearest = number - 1
        if nearest not in self._last:
            lower = [last for last in self._last if last < number]
            if not lower or len(self._last) < self._publishers():
                self._last.add(number)
                return 0
            nearest = max(lower)
        self._last.remove(nearest)
        self._last.add(number)
        return number - nearest - 1
