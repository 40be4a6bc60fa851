"""The twin node on its own: it follows a command in real time."""

from __future__ import annotations

import time

from rclpy.node import Node

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes import diagnostics
from ema_bench_replay.nodes.spin import steady_timer

from ..live.pace import Pace
from ..live.real_time import DeadlineClock
from ..live.standalone import Standalone
from ..model import Model
from ..simulation.command import Command
from ..simulation.twin import Twin
from .twin_output import TwinOutput


class OwnClock:
    """Sends a sample every period; missed periods are counted and integrated across.

    Stamps are whole periods after the start, so a missed one shows as a gap of stamps, not of sequence.

    Attributes:
        deadlines: counts of periods missed.
        failure: why the twin cannot go on; None while it can.
    """

    def __init__(self, node: Node, model: Model, output: TwinOutput, command: Command, rate: float) -> None:
        """`rate` is the number of samples a second."""
        self._output = output
        self._logger = node.get_logger()
        self.failure: InputError | None = None
        self._standalone = Standalone(model, command)
        self._period = round(1e9 / rate)
        self._run = int(time.time()) % 2**32
        self._sequence = 0
        self._epoch = time.time_ns()
        self._begun = False
        self.deadlines = DeadlineClock(self._period, time.monotonic_ns())
        steady_timer(node, self._period * 1e-9, self._on_time)

    @property
    def twin(self) -> Twin:
        """The present twin."""
        return self._standalone.twin

    @property
    def pace(self) -> Pace:
        """How fast the twin computes."""
        return self._standalone.pace

    def _on_time(self) -> None:
        if not self._begun:  # time before this, such as other nodes' start, is no delay
            self._begun, self._epoch = True, time.time_ns()
            self.deadlines = DeadlineClock(self._period, time.monotonic_ns())
        number = self.deadlines.tick(time.monotonic_ns())
        if number is None or self.failure is not None:
            return
        elapsed = number * self._period
        try:
            answer = self._standalone.answer(elapsed)
        except InputError as error:  # raised here, it would be logged with its whole traceback
            self.failure = error
            self._logger.error(str(error))
            return
        self._output.send(self._epoch + elapsed, self._run, self._sequence, answer)
        self._sequence += 1

    def report(self) -> diagnostics.Report:
        """Whether real time is kept."""
        missed = self.deadlines.missed
        figures = {
            "input": "standalone",
            "run": self._run,
            "periods missed": missed,
            "longest delay": f"{self.deadlines.worst * 1e-6:.1f} ms",
            "computes at": self.pace.in_words,
        }
        if self.failure is not None:
            return diagnostics.Report(diagnostics.ERROR, f"{self.failure}; start the node again", figures)
        if self.pace.complaint:
            return diagnostics.Report(diagnostics.WARN, self.pace.complaint, figures)
        if missed:
            return diagnostics.Report(diagnostics.WARN, f"{missed} periods missed; integrated across", figures)
        return diagnostics.Report(diagnostics.OK, "follows its command in real time", figures)
