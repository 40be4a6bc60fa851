"""The node `monitor`: compares the twin with its bench, sample by sample, and says how well it follows."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rcl_interfaces.msg import ParameterEvent, SetParametersResult
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_parameter_events

from ema_bench_replay.nodes import diagnostics, qos
from ema_bench_replay.nodes.incoming import Incoming
from ema_bench_replay.nodes.messages import header, signals_message
from ema_bench_replay.nodes.parameters import Declaration, check_all, declare, refuse_unknown
from ema_bench_replay.nodes.sample_codec import write_residual
from ema_bench_replay.nodes.spin import run, steady_timer
from ema_bench_replay.nodes.whole_or_none import whole_or_none
from ema_bench_replay.sample import State
from ema_twin_msgs.msg import EmaState, Health, Residual, Run

from ..comparison.running_comparison import RunningComparison
from ..live.follower import input_for
from ..live.live_model import live_model
from ..live.mixing import Mixing
from ..live.pairing import Pairing
from ..live.trend import Trend
from ..live.verdict import Level, errors_in_words, level_of
from ..live.waiting import CAPACITY
from ..model import Model
from ..own_effects import load_effects
from ..simulation.compared_signals import UNITS, driving, noise_floors
from .diagnosing.history import History
from .diagnosing.node import DiagnosisNode, Watched

PARAMETERS = (
    Declaration("model", "polito_bench", "model of the machine, for the sensors' noise: a shipped name or a YAML file"),
    Declaration("effect_files", (), "Python files with effects of your own, which are run: see the twin's parameter"),
    Declaration(
        "input", "auto", "what drives the twin: see the twin's parameter", choices=("auto", "setpoint", "current")
    ),
    Declaration("from_start", True, "also take samples that were sent before this node started"),
    Declaration("window", 5.0, "length of the window for the health level", "s", 0.01, 60.0),
    Declaration("warn_at", 3.0, "RMSE over noise floor at which health is WARN", "1", 1.0, 1e6, fixed=False),
    Declaration("error_at", 10.0, "RMSE over noise floor at which health is ERROR", "1", 1.0, 1e6, fixed=False),
    Declaration("stale_after", 1.0, "time without a sample after which health is STALE", "s", 0.1, 60.0, fixed=False),
    Declaration("services", True, "serve monitor/diagnose and monitor/apply"),
    Declaration("twin", "twin", "name of the twin's node, whose parameters the services read and set"),
    Declaration("history", 150_000, "samples kept for a diagnosis: 5 minutes at 500 Hz", "1", 1000, 1_000_000),
    Declaration("results", "", "campaign results whose healthy recordings the running unit is compared with"),
    Declaration("unit", "", "the running unit; required if the results hold several"),
    Declaration("healthy", "", "which of its recordings are healthy; same syntax as units --healthy"),
    Declaration(
        "judged_after", 60.0, "a continuing run is judged each time this long, by its last part", "s", 1.0, 3600.0
    ),
    Declaration("capacity", CAPACITY, "largest number of unpaired samples kept for each side", "1", 1, 1_000_000),
)

if TYPE_CHECKING:
    from ..live.unit_watch import UnitWatch

_HEALTH_PERIOD = 0.1
"""Period of the health messages in s."""
_SETTLED = 2.0
"""Time in s of comparing after which the diagnosing process is started: a run that ends sooner is not diagnosed."""

PairListener = Callable[[int, Mapping[str, float], Mapping[str, float], Mapping[str, float]], None]
"""Called with a pair's stamp [ns since the epoch], bench signals, twin signals and residuals (SI)."""


@whole_or_none
class MonitorNode(Node):
    """Publishes the residual of every pair of samples, and health ten times a second.

    Samples are paired by run and sequence, in either order of arrival (see `pairing`); statistics start again with each
    run. Health is STALE if nothing arrives before the run is complete.

    Attributes:
        pairing: counts of what arrived, and of what is missing.
        comparison: the statistics of the present run.
        diagnosis_services: diagnoses and applies; None if they are switched off.
        announced: the last message on `bench/run`; None before the first.
        unit_watch: judges the running unit's health; None if no results were given.
        on_pair: called for every pair, if given.
    """

    def __init__(
        self,
        model: Model | None = None,
        *,
        parameters: Sequence[Parameter] = (),
        context: Context | None = None,
        noise: Mapping[str, float] | None = None,
    ) -> None:
        """Compare by the noise of `model`, or of the model that the parameter names. Raises InputError if it is wrong.

        `noise` is the noise floor of the recording that is played, if it is known.
        """
        super().__init__("monitor", parameter_overrides=list(parameters), context=context)
        given = declare(self, PARAMETERS)
        refuse_unknown(self)
        load_effects(given["effect_files"])
        self.model = live_model(model or given["model"])
        self._noise = noise
        self._input, self._window, self._from_start = given["input"], given["window"], given["from_start"]
        self._limits = {name: given[name] for name in ("warn_at", "error_at", "stale_after")}
        noise_floors(self.model)  # computed once; otherwise the first comparison has to
        self.pairing = Pairing(given["capacity"], given["from_start"])
        self.comparison = self._new_comparison("setpoint" if self._input == "auto" else self._input)
        self.on_pair: PairListener | None = None
        self.announced: Run | None = None
        self._stamp = 0
        self._first_stamp = 0
        self._bench_arrival = self._pair_arrival = -math.inf
        self._first_pair = math.inf
        self._prepared = False
        self._history = History(given["history"])
        self._trend = Trend(self._window)
        self._incoming = {side: Incoming(f"{side}/state") for side in ("bench", "twin")}
        self._mixing = {"bench/state": Mixing(self.pairing.bench), "twin/state": Mixing(self.pairing.twin)}

        self.unit_watch: UnitWatch | None = None
        self._judged_after, self._judged_at = round(given["judged_after"] * 1e9), 0
        if given["results"]:
            from ..live.unit_watch import UnitWatch  # loads libraries that are needed only here

            self.unit_watch = UnitWatch.opened(Path(given["results"]), given["unit"], given["healthy"])
            diagnostics.Diagnostics(self, "health of the unit", self.unit_watch.unit, self._report_unit)

        self._residual_publisher = self.create_publisher(Residual, "monitor/residual", qos.RESIDUAL)
        self._health_publisher = self.create_publisher(Health, "monitor/health", qos.LATEST)
        self._diagnostics = diagnostics.Diagnostics(self, "twin against bench", self.model.name, self._report)
        states = qos.state(given["from_start"])
        self.create_subscription(EmaState, "bench/state", self._on_bench, states, raw=True)
        self.create_subscription(EmaState, "twin/state", self._on_twin, states, raw=True)
        self.create_subscription(Run, "bench/run", self._on_run, qos.LATEST)
        self.add_on_set_parameters_callback(self._on_parameters)
        names = {name: self.resolve_service_name(f"monitor/{name}") for name in ("diagnose", "apply")}
        names["diagnosis"] = self.resolve_topic_name("monitor/diagnosis")
        watched = Watched(
            self.get_name(), self.get_namespace(), names, given["twin"], self.model, self._history, self._place
        )
        self.diagnosis_services = DiagnosisNode(watched, context) if given["services"] else None
        own = self.get_namespace().rstrip("/")
        self._twin_name = given["twin"] if given["twin"].startswith("/") else f"{own}/{given['twin']}"
        self.create_subscription(ParameterEvent, "/parameter_events", self._on_change, qos_profile_parameter_events)
        steady_timer(self, _HEALTH_PERIOD, self._publish_health)

    @property
    def ready_words(self) -> str:
        """What the node logs when it is ready."""
        bench, twin = (self.resolve_topic_name(f"{side}/state") for side in ("bench", "twin"))
        return f"compares {bench} with {twin}; health on {self.resolve_topic_name('monitor/health')}"

    @property
    def expected(self) -> int:
        """Number of samples of the present run, as announced on `bench/run`; 0 if it is unknown."""
        announced = self.announced
        if not self._from_start or announced is None or announced.run != self.pairing.run:
            return 0
        return announced.samples

    @property
    def mixed(self) -> str:
        """A warning if several nodes publish one of the two states, else empty."""
        topics = [topic for topic, mixing in self._mixing.items() if mixing.mixed]
        if not topics:
            return ""
        both = " and ".join(topics)
        return f"more than one node publishes {both}: their samples mix; stop one, or use another ROS_DOMAIN_ID"

    @property
    def complete(self) -> bool:
        """Whether every sample of the run was compared; if its length is unknown, every sample so far."""
        pairing = self.pairing
        return pairing.compared == self.expected if self.expected else pairing.compared > 0 and not pairing.missing

    def _on_bench(self, message: bytes) -> None:
        self._bench_arrival = time.monotonic()
        sample = self._incoming["bench"].read(message)
        if sample is None:
            return
        passes = self.pairing.passes
        answer = self.pairing.add_bench(sample)
        if self.pairing.passes != passes:
            self._judge_unit()
            self.comparison = self._new_comparison(input_for(self._input, sample.signals, self.model))
            self._stamp = self._first_stamp = self._judged_at = sample.stamp
        if answer is not None:
            self._compare(sample, answer)

    def _on_twin(self, message: bytes) -> None:
        answer = self._incoming["twin"].read(message)
        if answer is None:
            return
        sample = self.pairing.add_twin(answer)
        if sample is not None:
            self._compare(sample, answer)

    def _on_run(self, message: Run) -> None:
        self.announced = message

    def _on_change(self, event: ParameterEvent) -> None:
        if event.node == self._twin_name and (event.changed_parameters or event.new_parameters):
            self._trend.clear()  # the twin was changed or restarted

    def _compare(self, bench: State, twin: State) -> None:
        residuals = self.comparison.add(bench.signals, twin.signals, bench.stamp * 1e-9)
        self._history.add(self.pairing.passes, bench)
        self._stamp = bench.stamp
        self._pair_arrival = time.monotonic()
        if not self._prepared:
            self._first_pair = min(self._first_pair, self._pair_arrival)
        self._residual_publisher.publish(write_residual(bench.stamp, bench.run, bench.sequence, residuals))
        if self.on_pair is not None:
            self.on_pair(bench.stamp, bench.signals, twin.signals, residuals)

    def _new_comparison(self, source: str) -> RunningComparison:
        return RunningComparison(self.model, source, self._window, noise=self._noise)

    def _level(self, rmse_window: Mapping[str, float]) -> tuple[Level, str]:
        if mixed := self.mixed:  # before STALE: if two benches mix, hardly any sample is answered
            return Level.ERROR, mixed
        now, patience = time.monotonic(), self._limits["stale_after"]
        over = self.expected and self.complete
        if not over and now - self._pair_arrival > patience:
            silent = now - self._bench_arrival > patience
            return Level.STALE, "no samples received" if silent else "the twin does not answer the bench's samples"
        comparison = self.comparison
        driven = driving(comparison.source)
        limits = self._limits["warn_at"], self._limits["error_at"]
        return level_of(rmse_window, comparison.noise_floor, driven, *limits)

    def _place(self) -> tuple[str, int]:
        return self.announced.recording if self.announced is not None else "bench", self.pairing.run or 0

    def _publish_health(self) -> None:
        comparison, pairing = self.comparison, self.pairing
        rmse_window = comparison.rmse_window
        for topic, mixing in self._mixing.items():
            mixing.look(self.count_publishers(topic))
        self._trend.add((self._stamp - self._first_stamp) * 1e-9, rmse_window)
        if (self.expected and self.complete) or self._stamp - self._judged_at >= self._judged_after:
            self._judge_unit()
        if self.diagnosis_services is not None and time.monotonic() - self._first_pair > _SETTLED:
            self._prepared, self._first_pair = True, math.inf
            self.diagnosis_services.prepare()
        self._health_publisher.publish(
            Health(
                header=header(self._stamp),
                run=pairing.run or 0,
                level=bytes([self._level(rmse_window)[0]]),
                complete=self.complete,
                compared=pairing.compared,
                missing=pairing.missing,
                expected=self.expected,
                window=self._window,
                rmse=signals_message(comparison.rmse),
                rmse_window=signals_message(rmse_window),
                noise_floor=signals_message(comparison.noise_floor),
                rmse_trend=signals_message(self._trend.slopes()),
            )
        )

    def _judge_unit(self) -> None:
        """Judge the last `judged_after` s of the present run (all of a shorter one), if anything arrived since."""
        if self.unit_watch is None or self._stamp <= self._judged_at:
            return
        stretch = min(self._stamp - self._first_stamp, self._judged_after) * 1e-9
        self._judged_at = self._stamp
        self.unit_watch.judge(lambda: self._history.recordings(stretch, self._place()[0])[-1], stretch)

    def health_of_unit(self) -> dict[str, object] | None:
        """The running unit's health, including its last samples; None if no results were given."""
        watch = self.unit_watch
        if watch is None:
            return None
        self._judge_unit()
        return {"unit": watch.unit, "off": watch.off, "words": watch.words, "figures": dict(watch.figures)}

    def _report_unit(self) -> diagnostics.Report:
        watch = self.unit_watch
        assert watch is not None  # reported only if there is one
        return diagnostics.Report(diagnostics.WARN if watch.off else diagnostics.OK, watch.words, watch.figures)

    def _report(self) -> diagnostics.Report:
        pairing = self.pairing
        comparison = self.comparison
        rmse_window = comparison.rmse_window
        level, words = self._level(rmse_window)
        wrong = [one.complaint for one in self._incoming.values() if one.complaint]
        words = "; ".join([words, *wrong])
        unseen = min(pairing.bench.unseen, pairing.missing)
        if unseen:
            words = f"{words}; {unseen} samples of this run were sent before this node received its first"
        if pairing.missing > unseen:
            words = f"{words}; {pairing.missing - unseen} samples of this run are missing"
        if growing := self._trend.growing():
            words = (
                f"{words}; the error of the {growing[0].replace('_', ' ')} grows by {100.0 * growing[1]:.0f} % per hour"
            )
        figures: dict[str, object] = {
            "RMSE is that of the last": f"{self._window:g} s",
            **errors_in_words(rmse_window, comparison.noise_floor, UNITS),
            "missing effect": None if self.diagnosis_services is None else self.diagnosis_services.condition,
            "run": pairing.run,
            "samples compared": f"{pairing.compared} of {self.expected}" if self.expected else pairing.compared,
            "samples missing": pairing.missing,
            "every sample compared": self.complete,
            "samples that wait for their partner": pairing.waiting,
            "twin samples of a run that was left": pairing.outdated,
            **pairing.bench.figures("bench samples"),
            **pairing.twin.figures("twin samples"),
            **self._incoming["bench"].figures,
            **self._incoming["twin"].figures,
        }
        return diagnostics.Report(
            max(bytes([level]), diagnostics.WARN if pairing.missing or wrong else diagnostics.OK), words, figures
        )

    def close(self) -> None:
        """End the services and any diagnosis in progress."""
        if self.diagnosis_services is not None:
            self.diagnosis_services.close()
            self.diagnosis_services = None

    def destroy_node(self) -> None:
        """Close, then end the node."""
        self.close()
        super().destroy_node()

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        result = check_all(PARAMETERS, parameters)
        if result.successful:
            self._limits |= {p.name: float(p.value) for p in parameters if p.name in self._limits}
        return result


def main() -> int:
    """Run the node in this process; returns the exit status."""
    return run(MonitorNode, PARAMETERS)


if __name__ == "__main__":
    raise SystemExit(main())
