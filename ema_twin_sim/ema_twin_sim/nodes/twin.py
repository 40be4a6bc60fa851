"""The node `twin`: answers each bench sample with its own, or runs on its own clock."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from ema_bench_replay.nodes import diagnostics, qos
from ema_bench_replay.nodes.joint_states import JointStates
from ema_bench_replay.nodes.keep_all_publisher import KeepAllPublisher
from ema_bench_replay.nodes.parameters import Declaration, declare, refuse_unknown
from ema_bench_replay.nodes.spin import run, steady_timer
from ema_bench_replay.nodes.state_codec import read_state, write_state
from ema_twin_msgs.msg import EmaState

from ..command import FORMS, parse_command
from ..model import Model
from ..model_file import load_model
from ..twin import Twin
from .follower import Follower
from .model_parameters import ModelParameters
from .real_time import DeadlineClock
from .standalone import Standalone

PARAMETERS = (
    Declaration("model", "polito_bench", "model of the machine: a shipped name or a YAML file"),
    Declaration(
        "input",
        "auto",
        "what drives the twin: the bench's speed setpoint, its current (auto: the setpoint if there is one), or a command",
        choices=("auto", "setpoint", "current", "standalone"),
    ),
    Declaration("from_start", True, "take the samples that the bench sent before this node came"),
    Declaration("command", "sine:0.02:1", f"command of a standalone twin: {FORMS}"),
    Declaration("command_start", 0.0, "added to the command", "rad or rad/s of the slow shaft", -1e6, 1e6),
    Declaration("command_phase", 0.0, "phase that a periodic command begins with", "rad", -10.0, 10.0),
    Declaration("rate", 500.0, "samples a second of a standalone twin", "Hz", 1.0, 2000.0),
)


class TwinNode(Node):
    """Publishes `twin/state`.

    Beside a bench it answers each sample of `bench/state` with one of the same stamp, run and sequence, by the rule of
    `sample_stream`. Standalone, it keeps its own time: periods that it misses are counted, and integrated across.
    """

    def __init__(
        self,
        model: Model | None = None,
        *,
        parameters: Sequence[Parameter] = (),
        context: Context | None = None,
    ) -> None:
        """Run `model`, or the one that the parameter names. Raises InputError where a parameter is wrong."""
        super().__init__("twin", parameter_overrides=list(parameters), context=context)
        given = declare(self, PARAMETERS)
        model = model or load_model(given["model"])
        self._publisher = KeepAllPublisher(self, EmaState, "twin/state", qos.STATE)
        self._joints = JointStates(self, "twin/joint_states")
        self._follower: Follower | None = None
        if given["input"] == "standalone":
            command = parse_command(given["command"], start=given["command_start"], phase=given["command_phase"])
            self._standalone = Standalone(model, command)
            report = self._standalone_report
        else:
            self._follower = Follower(model, given["input"], given["from_start"])
            report = self._follower_report
        ModelParameters(self, self._twin)
        refuse_unknown(self)
        self._diagnostics = diagnostics.Diagnostics(self, model.name, report)
        if self._follower:
            states = qos.state(given["from_start"])
            self.create_subscription(EmaState, "bench/state", self._on_bench, states, raw=True)
        else:
            self._start_clock(given["rate"])

    def _twin(self) -> Twin:
        return self._follower.twin if self._follower else self._standalone.twin

    def _on_bench(self, message: bytes) -> None:
        run, sequence, stamp, sample = read_state(message)
        answer = self._follower.answer(run, sequence, stamp, sample)
        if answer is not None:
            answer["motor_angle_origin"] = sample["motor_angle_origin"]
            answer["output_angle_origin"] = sample["output_angle_origin"]
            self._send(stamp, run, sequence, answer)

    def _start_clock(self, rate: float) -> None:
        self._period = round(1e9 / rate)
        self._run = int(time.time()) % 2**32
        self._sequence = 0
        self._epoch = time.time_ns()
        self._deadlines = DeadlineClock(self._period, time.monotonic_ns())
        steady_timer(self, self._period * 1e-9, self._on_time)

    def _on_time(self) -> None:
        number = self._deadlines.tick(time.monotonic_ns())
        if number is not None:
            elapsed = number * self._period
            self._send(self._epoch + elapsed, self._run, self._sequence, self._standalone.answer(elapsed))
            self._sequence += 1

    def _send(self, stamp: int, run: int, sequence: int, signals: dict[str, float]) -> None:
        self._publisher.send(write_state(stamp, run, sequence, signals))
        self._joints.publish(stamp, signals)

    def _follower_report(self) -> diagnostics.Report:
        follower, stream = self._follower, self._follower.stream
        if follower.problem:
            level, message = diagnostics.ERROR, follower.problem
        elif stream.run is None:
            level, message = diagnostics.WARN, "no sample on bench/state yet"
        elif stream.lost:
            level, message = diagnostics.WARN, f"{stream.lost} samples of this run were lost; integrated across"
        else:
            level, message = diagnostics.OK, "answers the bench"
        figures = {
            "run": stream.run,
            "samples received": stream.received,
            "lost": stream.lost,
            "late": stream.late,
            "duplicate": stream.duplicate,
            "backward": stream.backward,
            "runs": stream.runs,
        }
        return diagnostics.Report(level, message, {"input": follower.input, **figures, **self._common_figures()})

    def _standalone_report(self) -> diagnostics.Report:
        figures = {
            "input": "standalone",
            "run": self._run,
            "missed periods": self._deadlines.missed,
            "longest delay [ms]": self._deadlines.worst * 1e-6,
        }
        if self._deadlines.missed:
            level, message = diagnostics.WARN, f"{self._deadlines.missed} periods missed; integrated across"
        else:
            level, message = diagnostics.OK, "keeps its own time"
        return diagnostics.Report(level, message, {**figures, **self._common_figures()})

    def _common_figures(self) -> dict[str, object]:
        effects = [name for name, instance in self._twin().effects.items() if instance.enabled]
        return {
            "samples sent": self._publisher.sent,
            "sent again, a reader was behind": self._publisher.repeated,
            "effects": ", ".join(effects) or "none",
        }


def main() -> int:
    """Run the node in this process; returns the exit status."""
    return run(TwinNode)


if __name__ == "__main__":
    raise SystemExit(main())
