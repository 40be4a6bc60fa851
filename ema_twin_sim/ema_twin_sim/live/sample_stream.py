"""What an arriving sample is: the next one, the first of a run, or one to leave out. No ROS.

The rule, for bench samples at the twin and for both streams at the monitor:

* another `run`, or a sequence number that begins at 0 again, restarts from that sample;
* a sequence number beyond the next one means that samples were *lost*: the twin integrates across the gap;
* a repetition of the last sample, or of one of the few before it, is a *duplicate* and left out;
* one of the few last samples that was counted as lost and arrives after all is *late* and left out: the twin has passed
  it;
* a sample that is earlier by more than a few samples, or whose stamp and number advance by different times, is left out
  until the next sample decides. If the next one follows from it, time has jumped: back, which restarts (*backward*), or
  forward, which is a gap. If the next one follows from the samples before, it was a *stray* with a wrong stamp or
  number.

"Few" is `REORDERED` samples.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from enum import Enum, auto

REORDERED = 10
"""Number of samples by which the transport, or the bench, may put one out of order."""


class Kind(Enum):
    """What to do with a sample."""

    FIRST = auto()
    NEXT = auto()
    LEFT_OUT = auto()


@dataclass(eq=False)
class SampleStream:
    """Judges the samples of one topic in their order of arrival, and counts."""

    from_start: bool = True  # whether a run's samples before the first that arrives count as unseen, or not at all
    run: int | None = None  # number of the present run; None before the first sample
    sequence: int = 0  # sequence number of the newest sample in it
    first: int = 0  # sequence number that the run is counted from
    received: int = 0  # samples of this run, without those left out
    lost: int = 0  # samples of this run skipped between the first that arrived and the newest (late ones included)
    unseen: int = 0  # samples of this run before the first that arrived; 0 if the run is counted from there
    late: int = 0  # see the module for this and the next three: counted since the node's start
    duplicate: int = 0
    backward: int = 0
    stray: int = 0
    runs: int = 0  # runs begun
    _gaps: deque[range] = field(default_factory=lambda: deque(maxlen=REORDERED))
    _first_stamp: int = 0
    _first_sequence: int = 0
    _stamp: int = 0
    _elsewhere: tuple[int, int] | None = None  # (sequence, stamp) of a sample that the next one decides on

    def figures(self, what: str) -> dict[str, object]:
        """The counts by name, for the diagnostics; `what` names the samples."""
        return {
            f"{what} received in this run": self.received,
            f"{what} lost in this run": self.lost,
            f"{what} of this run before the first that came": self.unseen,
            f"{what} that came late": self.late,
            f"{what} that came twice": self.duplicate,
            f"{what} that went back in time": self.backward,
            f"{what} with a wrong stamp or number": self.stray,
        }

    def accept(self, run: int, sequence: int, stamp: int) -> Kind:
        """Judge a sample, stamped in ns, and count it."""
        if run != self.run:
            return self._begin(run, sequence, stamp)
        waited, self._elsewhere = self._elsewhere, None
        ahead = sequence - self.sequence
        if stamp > self._stamp and ahead > 0 and self._agree(ahead, stamp - self._stamp):
            self.stray += waited is not None
            return self._next(sequence, stamp)
        if stamp == self._stamp:
            self.duplicate += 1
            self._elsewhere = waited
            return Kind.LEFT_OUT
        if stamp < self._stamp and -REORDERED <= ahead < 0 and stamp > self._first_stamp:
            if any(sequence in gap for gap in self._gaps):
                self.late += 1
            else:
                self.duplicate += 1
            self._elsewhere = waited
            return Kind.LEFT_OUT
        if sequence == 0:
            self.backward += 1
            return self._begin(run, sequence, stamp)
        if waited is None or not self._goes_on(waited, sequence, stamp):
            self.stray += waited is not None
            self._elsewhere = sequence, stamp
            return Kind.LEFT_OUT
        if stamp > self._stamp and ahead > 0:
            return self._next(sequence, stamp)
        self.backward += 1
        return self._begin(run, sequence, stamp)

    def _next(self, sequence: int, stamp: int) -> Kind:
        if sequence > self.sequence + 1:
            self.lost += sequence - self.sequence - 1
            self._gaps.append(range(self.sequence + 1, sequence))
        self.sequence = sequence
        self._stamp = stamp
        self.received += 1
        return Kind.NEXT

    def _agree(self, numbers: int, time: int) -> bool:
        """Whether this many samples take this long [ns], within `REORDERED` of the run's mean periods."""
        so_far, passed = self.sequence - self._first_sequence, self._stamp - self._first_stamp
        return so_far == 0 or abs(time * so_far - numbers * passed) <= REORDERED * passed

    def _goes_on(self, waited: tuple[int, int], sequence: int, stamp: int) -> bool:
        """Whether a sample follows from the one that waited, by its number and its stamp."""
        numbers, time = sequence - waited[0], stamp - waited[1]
        return 0 < numbers <= REORDERED and time > 0 and self._agree(numbers, time)

    def _begin(self, run: int, sequence: int, stamp: int) -> Kind:
        self._gaps.clear()
        self.run = run
        self.sequence = sequence
        self._stamp = self._first_stamp = stamp
        self._first_sequence = sequence
        self._elsewhere = None
        self.first = 0 if self.from_start else sequence
        self.lost = 0
        self.unseen = sequence - self.first
        self.received = 1
        self.runs += 1
        return Kind.FIRST
