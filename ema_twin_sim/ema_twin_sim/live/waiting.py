"""Samples of one side that wait for their partner of the other, by their number in a run. No ROS."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

CAPACITY = 25_000
"""Samples of a side that may wait: more than can be on their way. Fast DDS keeps 5000 for a reader at the writer's side
and 5000 at the reader's, on the way to the twin and on the way from it; then a publisher waits."""


class Stamped(Protocol):
    """What can be paired: it has a run, a sequence number in it, and a stamp [ns]."""

    @property
    def run(self) -> int:
        """Number of the run."""

    @property
    def sequence(self) -> int:
        """Number in the run, from 0."""

    @property
    def stamp(self) -> int:
        """Time in ns since the epoch."""


Sample = TypeVar("Sample", bound=Stamped)


class Waiting(Protocol[Sample]):
    """Samples of one run; where there are too many, the oldest go."""

    def __len__(self) -> int:
        """How many there are."""

    def keep(self, sample: Sample) -> None:
        """Let one wait."""

    def take(self, sequence: int) -> Sample | None:
        """The one of that number, which waits no longer; None where it does not wait."""

    def forget_before(self, sequence: int) -> None:
        """Let those go that have a smaller number."""

    def clear(self) -> None:
        """Let all go."""


class WaitingObjects(Generic[Sample]):
    """Keeps the objects themselves."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._capacity = capacity
        self._held: dict[int, Sample] = {}

    def __len__(self) -> int:
        return len(self._held)

    def keep(self, sample: Sample) -> None:
        """See `Waiting`."""
        self._held[sample.sequence] = sample
        if len(self._held) > self._capacity:
            del self._held[next(iter(self._held))]

    def take(self, sequence: int) -> Sample | None:
        """See `Waiting`."""
        return self._held.pop(sequence, None)

    def forget_before(self, sequence: int) -> None:
        """See `Waiting`."""
        self._held = {number: sample for number, sample in self._held.items() if number >= sequence}

    def clear(self) -> None:
        """See `Waiting`."""
        self._held.clear()
