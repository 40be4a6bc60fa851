"""The node `twin`: answers each bench sample with its own, or runs on its own clock."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes import diagnostics
from ema_bench_replay.nodes.parameters import Declaration, declare, refuse_unknown
from ema_bench_replay.nodes.spin import run
from ema_bench_replay.nodes.whole_or_none import whole_or_none

from ..live.live_model import live_model
from ..model import Model
from ..own_effects import load_effects
from ..simulation.command import FORMS, parse_command
from .beside_bench import BesideBench
from .model_parameters import ModelParameters
from .own_clock import OwnClock
from .twin_output import TwinOutput

PARAMETERS = (
    Declaration("model", "polito_bench", "model of the machine: a shipped name or a YAML file"),
    Declaration("effect_files", (), "Python files with effects of your own, which are run; models may hold them"),
    Declaration(
        "input",
        "auto",
        "input of the twin: the bench's speed setpoint or current (auto: the first that it sends), or its own command",
        choices=("auto", "setpoint", "current", "standalone"),
    ),
    Declaration("from_start", True, "also take samples that the bench sent before this node started"),
    Declaration("command", "sine:0.02:1", f"command of a standalone twin: {FORMS}"),
    Declaration("command_start", 0.0, "added to the command", "rad or rad/s (m or m/s) of the output", -1e6, 1e6),
    Declaration("command_phase", 0.0, "phase that a periodic command begins with", "rad", -10.0, 10.0),
    Declaration("rate", 500.0, "samples a second of a standalone twin", "Hz", 1.0, 2000.0),
)


@whole_or_none
class TwinNode(Node):
    """Publishes `twin/state`: answers to the bench's samples, or its own."""

    def __init__(
        self,
        model: Model | None = None,
        *,
        parameters: Sequence[Parameter] = (),
        context: Context | None = None,
    ) -> None:
        """Run `model`, or the model that the parameter names. Raises InputError if a parameter is wrong."""
        super().__init__("twin", parameter_overrides=list(parameters), context=context)
        given = declare(self, PARAMETERS)
        load_effects(given["effect_files"])
        model = live_model(model or given["model"])
        self._output = TwinOutput(self)
        self.mode: BesideBench | OwnClock
        if given["input"] == "standalone":
            command = parse_command(given["command"], start=given["command_start"], phase=given["command_phase"])
            self.mode = OwnClock(self, model, self._output, command, given["rate"])
        else:
            self.mode = BesideBench(self, model, self._output, given["input"], given["from_start"])
        ModelParameters(self, lambda: self.mode.twin)
        refuse_unknown(self)
        self._diagnostics = diagnostics.Diagnostics(self, "model", model.name, self._report)

    @property
    def failure(self) -> InputError | None:
        """Why the twin cannot go on; None while it can."""
        return self.mode.failure

    @property
    def ready_words(self) -> str:
        """What the node logs when it is ready."""
        model = self.mode.twin.model.name
        if isinstance(self.mode, OwnClock):
            return f"runs {model} standalone, with its own command"
        return f"answers every sample of {self.resolve_topic_name('bench/state')} with the model {model}"

    def model_as_it_stands(self, begun: Model) -> Model:
        """The running model: `begun` with its changes, and with the effects that were switched on since."""
        present = self.mode.twin.model
        kept = {name: held for name, held in present.effects.items() if held.enabled or name in begun.effects}
        return replace(present, effects=kept)

    def _report(self) -> diagnostics.Report:
        report = self.mode.report()
        effects = [name for name, instance in self.mode.twin.effects.items() if instance.enabled]
        more = {**self._output.figures, "effects switched on": ", ".join(effects) or "none"}
        return diagnostics.Report(report.level, report.message, {**report.values, **more})


def main() -> int:
    """Run the node in this process; returns the exit status."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")  # shows when equations are compiled
    return run(TwinNode, PARAMETERS)


if __name__ == "__main__":
    raise SystemExit(main())
