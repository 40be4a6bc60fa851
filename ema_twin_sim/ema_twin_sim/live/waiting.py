"""Samples of one side that wait for their partner from the other, by their number in a run. No ROS."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

CAPACITY = 25_000
"""Number of samples of a side that may wait: more than can be in transit. Fast DDS keeps 5000 samples per reader at the
writer and 500 at the reader (see loopback.xml), both on the way to the twin and on the way back; beyond that a
publisher waits. Where somebody's own profile is used, it keeps 5000 at the reader."""


class Stamped(Protocol):
    """A sample that can be paired: it has a run, a sequence number in it, and a stamp [ns]."""

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
    """Waiting samples of one run; if there are too many, the oldest are dropped."""

    def __len__(self) -> int:
        """Number of waiting samples."""

    def keep(self, sample: Sample) -> None:
        """Keep a sample until it is taken."""

    def take(self, sequence: int) -> Sample | None:
        """Remove and return the sample of this number; None if it is not waiting."""

    def forget_before(self, sequence: int) -> None:
        """Drop the samples with a smaller number."""

    def clear(self) -> None:
        """Drop all samples."""


class WaitingObjects(Generic[Sample]):
    """Keeps the sample objects themselves."""

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
