"""The twin node that follows a bench: it answers each bench sample with one of the same stamp, run and sequence."""

from __future__ import annotations

from rclpy.node import Node

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes import diagnostics, qos
from ema_bench_replay.nodes.incoming import Incoming
from ema_bench_replay.recording import ANGLE_ORIGINS
from ema_twin_msgs.msg import EmaState

from ..live.follower import Follower
from ..live.pace import Pace
from ..model import Model
from ..simulation.twin import Twin
from .twin_output import TwinOutput


class BesideBench:
    """Subscribes to `bench/state`, and answers by the rule of `sample_stream`.

    Attributes:
        follower: the twin and what it counts.
        incoming: what was wrong with the messages that arrived.
        failure: why the twin stopped answering this run; None if it answers. It starts again with the next run.
    """

    def __init__(self, node: Node, model: Model, output: TwinOutput, wanted: str, from_start: bool) -> None:
        """`wanted` drives the twin, see `Follower`; `from_start`: also answer samples sent before this node started."""
        self._output = output
        self.failure: InputError | None = None
        self._logger = node.get_logger()
        self._failed_run = 0
        self.follower = Follower(model, wanted, from_start)
        self.incoming = Incoming("bench/state")
        node.create_subscription(EmaState, "bench/state", self._on_sample, qos.state(from_start), raw=True)

    @property
    def twin(self) -> Twin:
        """The present twin."""
        return self.follower.twin

    @property
    def pace(self) -> Pace:
        """How fast the twin computes."""
        return self.follower.pace

    def _on_sample(self, message: bytes) -> None:
        state = self.incoming.read(message)
        if state is None:
            return
        run, sequence, stamp, sample = state
        if self.failure is not None and run == self._failed_run:
            return
        try:
            answer = self.follower.answer(run, sequence, stamp, sample)
        except InputError as error:  # raised here, it would be logged with its whole traceback
            self.failure, self._failed_run = error, run
            self._logger.error(f"{error}; the twin starts again with the next run")
            return
        self.failure = None
        if answer is not None:
            for name in ANGLE_ORIGINS:
                answer[name] = sample[name]
            self._output.send(stamp, run, sequence, answer)

    def report(self) -> diagnostics.Report:
        """Counts of the bench's samples, and any problem with them."""
        stream = self.follower.stream
        if self.failure is not None:
            level, message = diagnostics.ERROR, f"{self.failure}; the twin starts again with the next run"
        elif self.follower.problem:
            level, message = diagnostics.ERROR, self.follower.problem
        elif stream.run is None:
            level, message = diagnostics.WARN, "waiting for the first sample on bench/state"
        elif self.pace.complaint:
            level, message = diagnostics.WARN, self.pace.complaint
        elif self.incoming.complaint:
            level, message = diagnostics.WARN, self.incoming.complaint
        elif stream.lost:
            level = diagnostics.WARN
            message = f"{stream.lost} samples of this run were lost; the twin integrated across the gap"
        elif stream.unseen:
            level = diagnostics.WARN
            message = (
                f"{stream.unseen} samples of this run were sent before this node received its first; they are not "
                "answered"
            )
        else:
            level, message = diagnostics.OK, "answers every sample of the bench"
        state = {
            "input": self.follower.input,
            "run": stream.run,
            "samples answered": self.follower.answered,
            "computes at": self.pace.in_words,
        }
        counts = {"runs begun": stream.runs, **stream.figures("samples"), **self.incoming.figures}
        return diagnostics.Report(level, message, {**state, **counts})
