"""What is passed between the nodes of a live run and its caller, and the run's result."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from rclpy.parameter import Parameter

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes.replay import ReplayNode
from ema_bench_replay.nodes.spin import interrupted
from ema_bench_replay.recording import Recording

from ..comparison.running_comparison import SignalError
from ..live.idle_time import IdleTime
from ..live.no_bench import no_bench
from ..model import Model
from .monitor import MonitorNode
from .twin import TwinNode

TICK = 0.05
"""Interval in s between two batches of pairs."""


WAIT = 5.0
"""Time in s without a sample, after which it is said that no bench publishes."""

PATIENCE = 3.0
"""Time in s without any arrival after the last sample was sent; what is missing then will not come any more."""


class Pair(NamedTuple):
    """A bench sample, the twin's answer and their residuals (SI)."""

    stamp: int  # ns since the epoch
    bench: Mapping[str, float]
    twin: Mapping[str, float]
    residuals: Mapping[str, float]


class HealthAsked(NamedTuple):
    """By what the monitor judges the running unit's health: its parameters of the same names."""

    results: Path  # of a campaign
    unit: str  # empty: the only one
    healthy: str  # empty: the first third
    judged_after: float | None  # s; None: as the monitor has it

    @property
    def parameters(self) -> list[Parameter]:
        """These as parameters of the monitor."""
        given = {"results": str(self.results), "unit": self.unit, "healthy": self.healthy}
        after = {} if self.judged_after is None else {"judged_after": self.judged_after}
        return [Parameter(name, value=value) for name, value in (given | after).items()]


class Change(NamedTuple):
    """A parameter to set on the running twin."""

    after: float  # s since the run's first sample
    parameter: str  # for instance effects.backlash.enabled
    value: bool | float


@dataclass(frozen=True)
class LiveResult:
    """Result of a live run.

    `signals` are the monitor's errors per compared signal, as in `RunningComparison.result`. `complete`: whether every
    sample of the run was compared; only then are they what `compare` gives. `counts`: sent, compared, missing,
    expected. `pace` is the simulated time over the computing time of the twin; `elapsed` [s] from the first pair to the
    last. `twin` is the twin's final model, including effects that were switched on. `unrecorded` says why the recording
    of the topics is incomplete; empty if it is complete or was not asked for. `health` is the final
    `MonitorNode.health_of_unit`; None if it was not asked for.
    """

    name: str
    model: str
    input: str
    samples: int
    duration: float
    signals: Mapping[str, SignalError]
    complete: bool
    interrupted: bool
    counts: Mapping[str, int]
    warnings: tuple[str, ...] = ()
    pace: float | None = None
    elapsed: float = 0.0
    twin: Model | None = None
    unrecorded: str = ""
    health: Mapping[str, object] | None = None


@dataclass
class Session:
    """The nodes of one call, and what is passed between them and the caller."""

    twin: TwinNode
    monitor: MonitorNode
    replay: ReplayNode | None
    changes: list[Change]
    on_pairs: Callable[[Sequence[Pair]], None] | None
    notify: Callable[[str], None]
    stop: threading.Event
    pairs: list[Pair] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    first_stamp: int | None = None
    last_stamp: int = 0
    began: float = 0.0  # s on the monotonic clock; the next one too
    ended: float = 0.0
    started: float = field(default_factory=time.monotonic)
    told_of_no_bench: bool = False
    idle: IdleTime = field(default_factory=lambda: IdleTime(2.0 * TICK))

    def take_pair(
        self, stamp: int, bench: Mapping[str, float], twin: Mapping[str, float], residuals: Mapping[str, float]
    ) -> None:
        """Take a pair; the monitor calls this."""
        self.last_stamp = stamp
        self.ended = time.monotonic()
        if self.first_stamp is None:
            self.first_stamp = stamp
            self.began = self.ended
        if self.on_pairs is not None:
            self.pairs.append(Pair(stamp, bench, twin, residuals))

    def tick(self) -> None:
        """Pass the pairs on, make the changes that are due, and warn if several nodes publish one topic."""
        if self.pairs and self.on_pairs is not None:
            batch, self.pairs = self.pairs, []
            self.on_pairs(batch)
        if not self.told_of_no_bench and self.replay is None and time.monotonic() - self.started > WAIT:
            self.told_of_no_bench = True
            if not self.monitor.pairing.bench.received:
                self.notify(no_bench())
        elapsed = 0.0 if self.first_stamp is None else (self.last_stamp - self.first_stamp) * 1e-9
        while self.changes and self.first_stamp is not None and self.changes[0].after <= elapsed:
            self._make(self.changes.pop(0))
        warning = self.monitor.mixed
        if warning and warning not in self.warnings:
            self.warnings.append(warning)
            self.notify(f"warning: {warning}")

    def _make(self, change: Change) -> None:
        (answer,) = self.twin.set_parameters([Parameter(change.parameter, value=change.value)])
        if not answer.successful:
            raise InputError(f"twin: {answer.reason}")
        self.notify(f"{change.parameter} = {change.value} after {change.after:g} s")

    def over(self) -> bool:
        """Whether the caller stops, or all samples were sent and no more pairs will come.

        Raises InputError if the twin cannot go on.
        """
        if self.twin.failure is not None:
            raise self.twin.failure
        if self.stop.is_set():
            return True
        if self.replay is None or not self.replay.ended:
            return False
        if self.monitor.expected and self.monitor.complete:  # before its announcement a run may seem complete
            return True
        return self.idle.look(self._arrived, time.monotonic()) > PATIENCE

    @property
    def _arrived(self) -> tuple[int, ...]:
        """What has arrived so far at the monitor, which hears both the bench and the twin."""
        pairing = self.monitor.pairing
        return pairing.bench.received, pairing.twin.received, pairing.compared

    def result(self, recording: Recording | None, unrecorded: str = "") -> LiveResult:
        """The run's result; `unrecorded` says why the recording of the topics is incomplete."""
        pairing = self.monitor.pairing
        announced = self.monitor.announced
        expected = self.monitor.expected or pairing.seen
        return LiveResult(
            name=recording.name if recording else (announced.recording if announced else "bench"),
            model=self.monitor.model.name,
            input=self.monitor.comparison.source,
            samples=pairing.compared,
            duration=recording.duration
            if recording
            else (self.last_stamp - (self.first_stamp or self.last_stamp)) * 1e-9,
            signals=self.monitor.comparison.result(),
            complete=self.monitor.complete,
            interrupted=interrupted(),
            counts={
                "sent": self.replay.sent if self.replay else pairing.bench.received,
                "compared": pairing.compared,
                "missing": expected - pairing.compared if self.replay and self.replay.ended else pairing.missing,
                "expected": expected,
            },
            warnings=(*(recording.warnings if recording else ()), *self.warnings),
            pace=self.twin.mode.pace.overall,
            elapsed=self.ended - self.began,
            twin=self.twin.model_as_it_stands(self.monitor.model),
            unrecorded=unrecorded,
            health=self.monitor.health_of_unit(),
        )
