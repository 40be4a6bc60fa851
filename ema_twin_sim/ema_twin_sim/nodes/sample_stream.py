"""What an arriving sample is: the next one, the first of a run, or one to leave out. No ROS.

The rule, for bench samples at the twin and for both streams at the monitor:

* another `run`, or a stamp before the last one, starts again from that sample (*backward* counts the latter);
* a sequence number further on than the next means that samples were *lost*: the twin integrates on across the gap;
* the last sample once more, or one of the few before it, is a *duplicate* and left out;
* one of the few that were taken for lost and comes after all is *late* and left out: the twin has gone past it.

"Few" is `REORDERED` samples: further back than that, time went back.
"""

from __future__ import annotations

from collections import deque
from enum import Enum, auto

REORDERED = 10
"""Samples by which the transport, or the bench, may put one out of order."""


class Kind(Enum):
    """What to do with a sample."""

    FIRST = auto()
    NEXT = auto()
    LEFT_OUT = auto()


class SampleStream:
    """Judges the samples of one topic in their order of arrival, and counts.

    Attributes:
        run: number of the present run; None before the first sample.
        sequence: sequence number of the newest sample in it.
        first: sequence number that the run is counted from.
        received: samples of this run, those left out not among them.
        lost: samples of this run that did not come.
        late, duplicate, backward: see the module; since the node's start.
        runs: runs begun.
    """

    def __init__(self, from_start: bool = True) -> None:
        """`from_start`: what a run's samples before the first to arrive count as: lost, or never meant to be seen."""
        self._from_start = from_start
        self._gaps: deque[range] = deque(maxlen=REORDERED)
        self._first_stamp = 0
        self._stamp = 0
        self.run: int | None = None
        self.sequence = 0
        self.first = 0
        self.received = 0
        self.lost = 0
        self.late = 0
        self.duplicate = 0
        self.backward = 0
        self.runs = 0

    def figures(self, what: str) -> dict[str, object]:
        """The counts by name, for the diagnostics; `what` names the samples."""
        return {
            f"{what} received in this run": self.received,
            f"{what} lost in this run": self.lost,
            f"{what} that came late": self.late,
            f"{what} that came twice": self.duplicate,
            f"{what} that went back in time": self.backward,
        }

    def accept(self, run: int, sequence: int, stamp: int) -> Kind:
        """Judge a sample, stamped in ns, and count it."""
        if run != self.run:
            return self._begin(run, sequence, stamp)
        ahead = sequence - self.sequence
        if stamp > self._stamp and ahead > 0:
            if ahead > 1:
                self.lost += ahead - 1
                self._gaps.append(range(self.sequence + 1, sequence))
            self.sequence = sequence
            self._stamp = stamp
            self.received += 1
            return Kind.NEXT
        if stamp == self._stamp:
            self.duplicate += 1
            return Kind.LEFT_OUT
        if stamp < self._stamp and -REORDERED <= ahead < 0 and stamp > self._first_stamp:
            if any(sequence in gap for gap in self._gaps):
                self.late += 1
            else:
                self.duplicate += 1
            return Kind.LEFT_OUT
        self.backward += 1
        return self._begin(run, sequence, stamp)

    def _begin(self, run: int, sequence: int, stamp: int) -> Kind:
        self._gaps.clear()
        self.run = run
        self.sequence = sequence
        self._stamp = self._first_stamp = stamp
        self.first = 0 if self._from_start else sequence
        self.lost = sequence - self.first
        self.received = 1
        self.runs += 1
        return Kind.FIRST
