"""A twin that follows a bench sample by sample: when it starts, what it skips, where positions begin. No ROS."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ema_bench_replay.recording import moved_origin

from ..model import Model
from ..simulation.long_gaps import LONGEST_GAP
from ..simulation.simulate import DRIVING, input_by_signals
from ..simulation.twin import Twin
from .pace import Pace
from .sample_stream import Kind, SampleStream
from .warm_up import warm_up_twin

_ZERO_OF = {
    "motor_position": "motor_position",
    "output_position": "output_position",
    "output_command": "output_position",
}
"""Signals that are counted from the run's first sample, and the signal that gives their zero at that sample."""


def input_for(wanted: str, sample: Mapping[str, float], model: Model) -> str:
    """The input that drives a twin at this sample: as wanted; for `auto` by the rule of `simulation.choose_input`."""
    if wanted != "auto":
        return wanted
    return input_by_signals(not math.isnan(sample["speed_setpoint"]), not math.isnan(sample["current"]), model)


class Follower:
    """Answers each bench sample, by the rule of `sample_stream`.

    After a gap of more than LONGEST_GAP it starts again. A run's positions need not begin at zero (the bench may have
    been running): the twin counts from the first sample, and its answers are shifted back.

    Attributes:
        stream: counts of the samples that arrived.
        twin: the twin; its parameters may be changed between two samples.
        input: what drives it.
        answered: samples answered.
        problem: why samples are not answered; empty if they are.
        pace: how fast the twin computes.
    """

    def __init__(self, model: Model, wanted: str = "auto", from_start: bool = True) -> None:
        """`wanted` is `setpoint`, `current` or `auto`; for `from_start` see `SampleStream`."""
        self._wanted = wanted
        self.input = "setpoint" if wanted == "auto" else wanted
        warm_up_twin(model, self.input)
        self.twin = Twin(model, self.input)
        self.stream = SampleStream(from_start)
        self.answered = 0
        self.problem = ""
        self.pace = Pace()
        self._running = False
        self._stamp = 0
        self._zeros: dict[str, float] = {}

    def answer(self, run: int, sequence: int, stamp: int, sample: dict[str, float]) -> dict[str, float] | None:
        """The twin's signals at this sample (SI, stamped in ns); None if the sample is left out.

        A run's samples before the first one with a value of the driving signal are left out, and `problem` says so.
        """
        kind = self.stream.accept(run, sequence, stamp)
        if kind is Kind.LEFT_OUT:
            return None
        if kind is Kind.FIRST:
            self._choose_input(sample)
            self._running = False
        if self._running and stamp - self._stamp > LONGEST_GAP * 1e9:
            self._running = False  # a gap this long cannot be simulated: the twin starts again here
        if self._running:
            elapsed, moved = stamp - self._stamp, self._moved(sample, -1.0)
            answer = self.pace.timed(elapsed, lambda: self.twin.advance(elapsed, moved))
        elif math.isnan(sample[DRIVING[self.input]]):
            self.problem = f"the bench sends no {DRIVING[self.input]}, which the twin needs with input {self.input}"
            return None
        else:
            answer = self._start(sample)
        self._stamp = stamp
        self.answered += 1
        return self._moved(answer, 1.0)

    def _choose_input(self, sample: Mapping[str, float]) -> None:
        wanted = input_for(self._wanted, sample, self.twin.model)
        if wanted != self.input:
            self.twin = Twin(self.twin.model, wanted)
            self.input = wanted

    def _start(self, sample: dict[str, float]) -> dict[str, float]:
        self.problem = ""
        self._running = True
        zeros = {name: sample[origin] for name, origin in _ZERO_OF.items()}
        self._zeros = {name: zero for name, zero in zeros.items() if zero and math.isfinite(zero)}
        return self.twin.start(
            self._moved(sample, -1.0),
            moved_origin(sample["motor_angle_origin"], self._zeros.get("motor_position", 0.0)),
            moved_origin(sample["output_angle_origin"], self._zeros.get("output_position", 0.0)),
        )

    def _moved(self, signals: dict[str, float], direction: float) -> dict[str, float]:
        """The signals, those counted from the first sample shifted to the twin's zero (-1) or back (1)."""
        if not self._zeros:
            return signals
        return {**signals, **{name: signals[name] + direction * zero for name, zero in self._zeros.items()}}
