"""A unit's health: each recording judged against the unit's healthy ones, from the features in the store."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Any

import numpy as np

from ema_bench_replay.errors import InputError

from ..health.baseline import FEWEST_TESTS, Baseline, learn_from
from ..health.comparable import unlike
from ..health.false_alarms import FALSE_ALARM
from ..health.families import Family, Ranked
from ..health.judgement import HealthJudgement, judge_run, naming_together
from ..health.motion_record import MotionRecord
from ..health.naming import Naming
from ..health.run_features import RunFeatures, kinds_of_motion, run_features
from ..listing import first_of
from .health_rows import run_of
from .healthy import BY_DEFAULT, Healthy
from .results import DONE
from .units import Unit


@dataclass(frozen=True, eq=False)
class JudgedTest:
    """The judged recordings of one test."""

    name: str
    runs: tuple[HealthJudgement, ...]
    kinds: tuple[int, ...]  # of the runs' motions: the place of the baseline that each was judged by

    @property
    def judged(self) -> int:
        """Number of recordings that could be judged."""
        return sum(run.detected is not None for run in self.runs)

    @property
    def detected(self) -> int:
        """Number of recordings that differ from the healthy ones."""
        return sum(bool(run.detected) for run in self.runs)

    @property
    def deviates(self) -> bool:
        """Whether more than half of the judged recordings of some kind of motion differ from the healthy ones.

        A fault may show in one kind alone, such as a slow stroke.
        """
        return bool(self._deviating)

    @property
    def named(self) -> Ranked | None:
        """The fault family by all of these together; None if nothing was detected, or no family explains it."""
        naming = self._naming
        return None if naming.family is Family.UNKNOWN else naming.ranked[0]

    @property
    def why(self) -> str:
        """What all of these together are called and why, or why no family is named, in a sentence or two."""
        return self._naming.sentence

    @property
    def worst(self) -> HealthJudgement:
        """The recording that is farthest from the healthy ones."""
        return max(self.runs, key=lambda run: -1.0 if run.detected is None else run.distance)

    @property
    def reason(self) -> str:
        """Why none of its recordings could be judged; empty if one could."""
        return self.runs[-1].words[-1] if not self.judged else ""

    def as_json(self) -> dict[str, object]:
        """Absent numbers are null."""
        named = self.named
        return {
            "test": self.name,
            "recordings": len(self.runs),
            "judged": self.judged,
            "detected": self.detected,
            "deviates": self.deviates,
            "family": None if named is None else named.family.value,
            "probability": None if named is None else named.probability,
            "runs": [_run_json(run) for run in self.runs],
        }

    @property
    def _naming(self) -> Naming:
        """What the recordings of the kinds of motion that deviate are called; of all kinds if none does."""
        return naming_together(self._deviating or self.runs)

    @property
    def _deviating(self) -> tuple[HealthJudgement, ...]:
        """The judged recordings of the kinds of motion in which more than half of them differ."""
        found: tuple[HealthJudgement, ...] = ()
        for kind in sorted(set(self.kinds)):
            judged = tuple(run for run, its in zip(self.runs, self.kinds, strict=True) if its == kind)
            judged = tuple(run for run in judged if run.detected is not None)
            found += judged if 2 * sum(bool(run.detected) for run in judged) > len(judged) else ()
        return found


@dataclass(frozen=True, eq=False)
class UnitHealth:
    """A unit's health: a baseline for each kind of motion, and the judged tests in their order."""

    baselines: tuple[Baseline, ...]
    tests: tuple[JudgedTest, ...]  # none of them was learnt from
    reference: tuple[JudgedTest, ...]  # those that were learnt from, if any of the others deviates
    remarks: tuple[str, ...]  # recordings that could not be learnt from or judged, and why

    @property
    def off(self) -> tuple[JudgedTest, ...]:
        """The tests that deviate."""
        return tuple(test for test in self.tests if test.deviates)

    @property
    def lasting(self) -> tuple[JudgedTest, ...]:
        """The deviating tests at the end, since the last one that was like the healthy ones; empty if that is last."""
        return tuple(takewhile(lambda test: test.deviates, reversed(self.judged)))[::-1]

    @property
    def judged(self) -> tuple[JudgedTest, ...]:
        """The tests that could be judged."""
        return tuple(test for test in self.tests if test.judged)

    @property
    def blind(self) -> tuple[JudgedTest, ...]:
        """The tests at the end that could not be judged, since the last one that could; empty if that is last."""
        return tuple(takewhile(lambda test: not test.judged, reversed(self.tests)))[::-1]

    @property
    def unknown(self) -> bool:
        """Whether it is not known how the unit is now, because no test, or not the last one, could be judged."""
        return not self.tests or bool(self.blind)

    @property
    def conspicuous(self) -> bool:
        """Whether somebody should look at the unit: a test deviates, or it is not known how it is now."""
        return bool(self.off) or self.unknown

    @property
    def severity(self) -> tuple[bool, bool, float, float]:
        """Sort key: whether the last judged test deviates, whether it is unknown how the unit is now, the share of the
        judged tests that deviate, and how far the last of these does.
        """
        if not self.off:
            return False, self.unknown, 0.0, 0.0
        return bool(self.lasting), self.unknown, len(self.off) / len(self.judged), self.off[-1].worst.distance

    def as_json(self) -> dict[str, object]:
        """SI units."""
        return {
            "healthy": [
                {
                    "tests": one.tests,
                    "recordings": one.runs,
                    "false_alarm": one.false_alarm,
                    "false_alarms_left_out": one.false_alarms_left_out,
                }
                for one in self.baselines
            ],
            "since": self.lasting[0].name if self.lasting else None,
            "not_judged_since": self.blind[0].name if self.blind else None,
            "tests": [test.as_json() for test in self.tests],
            "remarks": list(self.remarks),
        }


@dataclass(frozen=True, eq=False)
class Learnt:
    """What was learnt from a unit's healthy recordings: a baseline for each kind of motion."""

    kinds: tuple[Baseline, ...]
    remarks: tuple[str, ...]  # recordings that could not be learnt from, and why

    def kind(self, run: RunFeatures) -> int:
        """The place of the baseline whose motion is nearest to that of a run."""
        if run.features is None:
            return 0
        return min(range(len(self.kinds)), key=lambda place: unlike(run, self.kinds[place]))

    def features(self, record: MotionRecord) -> RunFeatures:
        """The features of a run with the wavelength of the baseline whose motion is nearest to its own."""
        run = run_features(record, self.kinds[0].wavelength)
        own = self.kinds[self.kind(run)].wavelength
        same = np.array_equal(own, run.wavelength, equal_nan=True)
        return run if same else run_features(record, own)

    def judge(self, run: RunFeatures) -> HealthJudgement:
        """Judge by the baseline of the nearest motion, which also says what differs."""
        return judge_run(run, self.kinds[self.kind(run)])

    def read(self, run: RunFeatures) -> RunFeatures:
        """The run with its effort read as that of the healthy runs, as a magnitude or not, where it leaves a doubt."""
        return run.read_as(self.kinds[self.kind(run)].unsigned) if self.kinds else run


def learnt_from(runs: Sequence[RunFeatures]) -> Learnt:
    """Learn the baselines of healthy runs, one for each kind of motion.

    Any of the kinds may call a test off, so they share the false alarms.
    """
    kinds = kinds_of_motion(runs)
    several = sum(len({run.test for run in kind}) >= FEWEST_TESTS for kind in kinds)
    learnt: list[Baseline] = []
    remarks: list[str] = []
    for kind in kinds:
        try:
            baseline = learn_from(kind, false_alarm=FALSE_ALARM / max(1, several))
        except InputError as error:
            these = first_of([run.name for run in kind])
            remarks.append(f"{these} cannot be the healthy reference: {error}")
            continue
        learnt.append(baseline)
        remarks += baseline.warnings
    if not runs:
        remarks.append("no healthy recording is selected, so its health is not judged; see --healthy")
    elif not kinds:
        reason = next((finding for run in runs for finding in run.acquisition.findings), "")
        remarks.append(f"none of its {len(runs)} healthy recordings is usable: {reason}".rstrip(": "))
    return Learnt(tuple(learnt), tuple(remarks))


def healthy_runs(unit: Unit, healthy: Healthy) -> tuple[list[RunFeatures], list[bool]]:
    """A unit's runs for which the campaign computed health features, and whether each is healthy."""
    runs = [
        run_of(row["name"], row["health"], row["duration"])
        for row in unit.rows
        if row["status"] == DONE and row["health"]
    ]
    return runs, healthy.among([run.name for run in runs], [run.test for run in runs], FEWEST_TESTS)


def unit_health(unit: Unit, healthy: Healthy) -> UnitHealth | None:
    """The health of a unit; None if the campaign computed no health features (``--do health``)."""
    runs, flags = healthy_runs(unit, healthy)
    if not runs:
        return None
    learnt = learnt_from([run for run, flag in zip(runs, flags, strict=True) if flag])
    read = [learnt.read(run) for run in runs]
    acquisition = dict.fromkeys(
        finding for run in read if run.features is not None for finding in run.acquisition.findings
    )
    remarks = (*learnt.remarks, *_undated(unit, healthy), *_alone(unit, runs), *acquisition)
    if not learnt.kinds:
        return UnitHealth((), (), (), remarks)
    tests = _judged(learnt, (run for run, flag in zip(runs, flags, strict=True) if not flag))
    reference = (run for run, flag in zip(runs, flags, strict=True) if flag)
    return UnitHealth(
        learnt.kinds,
        tests,
        _judged(learnt, reference) if any(test.deviates for test in tests) else (),
        remarks,
    )


def _undated(unit: Unit, healthy: Healthy) -> Iterator[str]:
    """Yield a remark if names alone tell which tests came first, and so by default which are healthy."""
    if healthy == BY_DEFAULT and all(row["time"] is None for row in unit.rows):
        yield (
            "no recording has a date, so the first third of its tests by name counts as healthy, whatever they hold; "
            "name the healthy ones with --healthy, or give the times by (?P<time>...) in campaign --unit"
        )


def _alone(unit: Unit, runs: Sequence[RunFeatures]) -> Iterator[str]:
    """Yield a remark if recordings count as tests of their own because nothing tells which belong together."""
    undated = {row["name"] for row in unit.rows if row["time"] is None}
    if sum(run.test == run.name for run in runs if run.name in undated) > 1:
        yield (
            "its recordings tell neither a date nor a test (what was set up once), so each counts as a test of its "
            "own; if several belong to one, put these into a folder, or name it by (?P<test>...) in campaign --unit"
        )


def _judged(learnt: Learnt, runs: Iterable[RunFeatures]) -> tuple[JudgedTest, ...]:
    """Judge runs; the tests in the order of their first ones."""
    tests: dict[str, list[RunFeatures]] = {}
    for run in runs:
        tests.setdefault(run.test, []).append(run)
    return tuple(
        JudgedTest(name, tuple(learnt.judge(run) for run in its), tuple(learnt.kind(run) for run in its))
        for name, its in tests.items()
    )


def sickest_first(units: Iterable[Unit], health: Mapping[str, UnitHealth | None]) -> list[Unit]:
    """Units by their health, those whose last judged test deviates first, then those that were not judged lately.

    They stay in their order where health says nothing else.
    """

    def severity(unit: Unit) -> tuple[bool, bool, float, float]:
        of = health[unit.name]
        return (False, False, 0.0, 0.0) if of is None else of.severity

    return sorted(units, key=severity, reverse=True)


def _run_json(run: HealthJudgement) -> Mapping[str, Any]:
    return {
        "name": run.name,
        "detected": run.detected,
        "distance": None if run.detected is None else run.distance,
        "family": None if run.family is None else run.family.value,
        "probability": run.sureness,
        "changes": {change.name: change.standard_deviations for change in run.changes},
        "words": list(run.words),
    }
