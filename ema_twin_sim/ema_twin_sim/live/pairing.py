"""Pair each bench sample with the twin's answer to it, whichever comes first. No ROS.

A *pass* is what a stream sends between two restarts; a restart is a new run, or a step back in time within a run. The
bench decides which pass is the present one. The twin goes through the same passes, seen here a little earlier or later.
A twin that was restarted goes back although the bench does not. It is recognised by bench samples that were not yet
answered: a twin that goes back because the bench did has answered them all.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from ema_bench_replay.sample import State

from .sample_stream import Kind, SampleStream
from .waiting import CAPACITY, Waiting


@dataclass
class _TwinPass:
    """Answers of one pass that wait for their bench samples."""

    run: int
    first: int
    waiting: Waiting
    newest: int = -1


class Pairing:
    """Pairs samples by run and sequence; keeps a bounded number of those whose partner has not arrived.

    Attributes:
        bench, twin: counts of what arrived on either side.
        compared: pairs of the present run.
        outdated: answers to samples of a run that the bench has left, since the start.
        passes: passes that the bench has begun.
    """

    def __init__(self, capacity: int = CAPACITY, from_start: bool = True) -> None:
        """Keep up to `capacity` unpaired samples of each pass and side; `from_start`: see `SampleStream`."""
        self._capacity = capacity
        self.bench = SampleStream(from_start)
        self.twin = SampleStream(from_start)
        self.compared = 0
        self.outdated = 0
        self.passes = 0
        self._waiting = Waiting(capacity)
        # The twin's answers to the present pass, and to passes that the bench, as seen here, has not begun yet.
        self._answers: _TwinPass | None = None
        self._ahead: deque[_TwinPass] = deque(maxlen=16)

    @property
    def run(self) -> int | None:
        """Number of the present run; None before the bench's first sample."""
        return self.bench.run

    @property
    def seen(self) -> int:
        """Samples of the run so far, including lost ones."""
        return 0 if self.run is None else self.bench.sequence + 1 - self._first

    @property
    def missing(self) -> int:
        """Samples of the run that can no longer be compared: both streams, each in order, are past them."""
        if self.run is None or self._answers is None:
            return 0
        return min(self.bench.sequence, self._answers.newest) + 1 - self._first - self.compared

    @property
    def waiting(self) -> int:
        """Samples of the present run whose partner has not arrived."""
        return len(self._waiting) + (len(self._answers.waiting) if self._answers else 0)

    def add_bench(self, sample: State) -> State | None:
        """Take a sample of the bench; return the twin's answer if it is here already."""
        kind = self.bench.accept(sample.run, sample.sequence, sample.stamp)
        if kind is Kind.LEFT_OUT:
            return None
        if kind is Kind.FIRST:
            self._begin(sample.run)
        elif self._ahead and self._ahead[0].run == sample.run and self._unanswered:
            self._go_on_with(self._ahead.popleft())
        answer = self._answers.waiting.take(sample.sequence) if self._answers else None
        if answer is None:
            self._waiting.keep(sample)
        else:
            self.compared += 1
        return answer

    def add_twin(self, sample: State) -> State | None:
        """Take an answer of the twin; return the bench's sample if it is here already."""
        kind = self.twin.accept(sample.run, sample.sequence, sample.stamp)
        if kind is Kind.LEFT_OUT:
            return None
        if kind is Kind.FIRST:
            self._begin_twin(sample.run)
        into = self._ahead[-1] if self._ahead else self._answers
        if into is None:
            self.outdated += 1
            return None
        into.newest = max(into.newest, sample.sequence)
        partner = self._waiting.take(sample.sequence) if into is self._answers else None
        if partner is not None:
            self.compared += 1
        elif into is not self._answers or sample.sequence > self.bench.sequence:
            into.waiting.keep(sample)  # else it was answered before the twin's restart
        return partner

    @property
    def _unanswered(self) -> bool:
        """Whether bench samples of the present pass are not answered yet.

        False if the twin goes back because the bench did: then it has answered all of them.
        """
        return self._answers is not None and self.bench.sequence > self._answers.newest

    @property
    def _first(self) -> int:
        return max(self.bench.first, self._answers.first) if self._answers else self.bench.first

    def _begin(self, run: int) -> None:
        """Begin a pass of the bench; the twin may have begun it already."""
        self.passes += 1
        self.compared = 0
        self._waiting.clear()
        self._answers = None
        while self._ahead and self._answers is None:
            begun = self._ahead.popleft()
            if begun.run == run:
                self._answers = begun
            else:
                self.outdated += len(begun.waiting)

    def _begin_twin(self, run: int) -> None:
        begun = _TwinPass(run, self.twin.first, Waiting(self._capacity))
        if self.run == run and (self._answers is None or self._unanswered):
            self.outdated += sum(len(older.waiting) for older in self._ahead)
            self._ahead.clear()
            self._go_on_with(begun)
        else:
            self._ahead.append(begun)

    def _go_on_with(self, begun: _TwinPass) -> None:
        """Continue the present pass after a restart of the twin; pairs compared before the restart stay counted."""
        if self._answers is not None:
            begun.first = self._answers.first
            begun.newest = max(begun.newest, self._answers.newest)
            begun.waiting.forget_before(self.bench.sequence)
        self._answers = begun
