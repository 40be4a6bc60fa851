"""What passes between the nodes of one live run and its caller, and what the run ended with."""

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
from ema_bench_replay.nodes.spin import (
    interrupted,
)
from ema_bench_replay.recording import Recording

from ..comparison.running_comparison import SignalError
from ..live.idle_time import IdleTime
from ..model import Model
from .monitor import MonitorNode
from .twin import TwinNode

TICK = 0.05
"""s between two batches of pairs."""


PATIENCE = 3.0
"""s in which nothing arrives anywhere after the last sample was sent: then what is missing will not come."""


class Pair(NamedTuple):
    """A bench sample, the twin's answer and their residuals (SI)."""

    stamp: int  # ns since the epoch
    bench: Mapping[str, float]
    twin: Mapping[str, float]
    residuals: Mapping[str, float]


class HealthAsked(NamedTuple):
    """By what the monitor judges the health of the unit that runs: its parameters of the same names."""

    results: Path  # of a campaign
    unit: str  # empty: the only one
    healthy: str  # empty: the first third
    judged_after: float | None  # s; None: as the monitor has it

    @property
    def parameters(self) -> list[Parameter]:
        """Those of the monitor."""
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
    """What the nodes ended with.

    `signals` is the monitor's, per compared signal, as in `RunningComparison.result`. `complete` tells whether every
    sample of the run was compared: only then is it what `compare` gives. `counts`: sent, compared, missing, expected.
    `pace` is the time that the twin simulated over the time that it computed; `elapsed` [s] from the first pair to the
    last. `twin` is the model that the twin ended with, the effects that were switched on among its own. `unrecorded`
    says in words why the recording of the topics is not whole; it is empty where it is, or none was asked for.
    `health` is what `MonitorNode.health_of_unit` told at the end; None where it was not asked for.
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
    began: float = 0.0  # s on the monotonic clock, and so the next
    ended: float = 0.0
    idle: IdleTime = field(default_factory=lambda: IdleTime(2.0 * TICK))

    def take_pair(
        self, stamp: int, bench: Mapping[str, float], twin: Mapping[str, float], residuals: Mapping[str, float]
    ) -> None:
        """Called by the monitor."""
        self.last_stamp = stamp
        self.ended = time.monotonic()
        if self.first_stamp is None:
            self.first_stamp = stamp
            self.began = self.ended
        if self.on_pairs is not None:
            self.pairs.append(Pair(stamp, bench, twin, residuals))

    def tick(self) -> None:
        """Hand on the pairs, make the changes that are due, look around."""
        if self.pairs and self.on_pairs is not None:
            batch, self.pairs = self.pairs, []
            self.on_pairs(batch)
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
        """Whether the caller stops, or all samples were sent and nothing more comes of them.

        Raises InputError where the twin cannot go on.
        """
        if self.twin.failure is not None:
            raise self.twin.failure
        if self.stop.is_set():
            return True
        if self.replay is None or not self.replay.ended:
            return False
        if self.monitor.expected and self.monitor.complete:  # a run that was not announced yet is complete at any time
            return True
        return self.idle.look(self._arrived, time.monotonic()) > PATIENCE

    @property
    def _arrived(self) -> tuple[int, ...]:
        """What has arrived so far at the monitor, which hears both the bench and the twin."""
        pairing = self.monitor.pairing
        return pairing.bench.received, pairing.twin.received, pairing.compared

    def result(self, recording: Recording | None, unrecorded: str = "") -> LiveResult:
        """What the nodes ended with, and what became of the recording of them."""
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
