"""The features of a run for the health judgement; with them it can be judged again without its samples."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from ..criteria import CONTRADICTED, NEGLIGIBLE, PART, SMALL
from .acquisition import Acquisition, judge_acquisition
from .between_tests import Prediction, predict
from .features import Features, features_of
from .motion_record import MotionRecord
from .phases import Phases, phases_of


@dataclass(frozen=True, eq=False)
class RunFeatures:
    """The acquisition, the features and the motion of one run of a unit."""

    name: str
    test: str
    acquisition: Acquisition
    features: Features | None  # None if the acquisition is not usable
    wavelength: float  # m or rad, of the wave that was fitted; NaN if there is none
    motion: tuple[float, float, float]  # sample period s, travel m or rad, top speed m/s or rad/s
    position_unit: str
    effort_unit: str
    otherwise: Features | None = None  # with the effort read the other way, if its sign is not certain

    @property
    def unsigned(self) -> bool:
        """Whether the features are those of a magnitude."""
        return self.acquisition.unsigned

    @property
    def commanded(self) -> bool:
        """Whether the motion is that of a command, and not what the machine made of it."""
        return self.features is not None and "lag" in self.features.values

    def read_as(self, unsigned: bool) -> RunFeatures:
        """The same with the effort read as a magnitude or not; unchanged if its sign is certain."""
        if self.otherwise is None or unsigned == self.unsigned:
            return self
        acquisition = self.acquisition.read_as(unsigned)
        return replace(self, acquisition=acquisition, features=self.otherwise, otherwise=self.features)


def run_features(record: MotionRecord, wavelength: float) -> RunFeatures:
    """Compute the features of a run. ``wavelength`` is in the position's unit, NaN for none.

    If it is not certain whether the effort is a magnitude, they are computed both ways.
    """
    acquisition = judge_acquisition(record)
    unsigned = acquisition.unsigned
    features, otherwise, motion = None, None, (np.nan, np.nan, np.nan)
    if acquisition.usable:
        phases = phases_of(record)
        features = features_of(record, wavelength, unsigned)
        if not acquisition.certain_of_sign:
            otherwise = features_of(record, wavelength, not unsigned)
        motion = float(np.median(np.diff(record.time))), phases.travel, phases.top_speed
        if np.isfinite(wavelength) and "wave_depth" not in features.values:
            acquisition = replace(acquisition, findings=(*acquisition.findings, _too_short(phases, record, wavelength)))
    return RunFeatures(
        record.name, record.test, acquisition, features, wavelength, motion, record.position_unit, record.effort_unit,
        otherwise,
    )  # fmt: skip


def _too_short(phases: Phases, record: MotionRecord, wavelength: float) -> str:
    strokes = phases.strokes(1) + phases.strokes(-1)
    longest = max(float(np.ptp(record.position[stroke.steady])) for stroke in strokes)
    return (
        "The wave that repeats with the position is not judged: the longest stroke is "
        f"{longest / wavelength:.2g} times its wavelength of {wavelength:.3g} {record.position_unit}. Record longer "
        "strokes, or correct the wavelength."
    )


def kinds_of_motion(runs: Iterable[RunFeatures]) -> list[list[RunFeatures]]:
    """Group runs that can be judged by their motion: features of another motion say nothing about these.

    All runs of a kind have their effort read alike, as a magnitude or not.
    """
    kinds: list[list[RunFeatures]] = []
    for run in runs:
        if run.features is not None:
            kind = next((kind for kind in kinds if all(map(alike, run.motion, kind[0].motion))), None)
            kinds.append([run]) if kind is None else kind.append(run)
    return [part for kind in kinds for part in _by_sign(kind)]


def _by_sign(kind: Sequence[RunFeatures]) -> list[list[RunFeatures]]:
    """Runs of one motion with their effort read as most of those do whose sign is certain, and apart the others."""
    unsigned = mostly_unsigned([run.acquisition for run in kind])
    read = [run.read_as(unsigned) for run in kind]
    parts = [[run for run in read if run.unsigned == flag] for flag in (unsigned, not unsigned)]
    return [part for part in parts if part]


def mostly_unsigned(runs: Sequence[Acquisition]) -> bool:
    """Whether most efforts are magnitudes; those decide of which it is certain whether they are."""
    flags = [run.unsigned for run in runs if run.certain_of_sign] or [run.unsigned for run in runs]
    return sum(flags) > 0.5 * len(flags)


def motion_limits(runs: Sequence[RunFeatures], tests: Sequence[str]) -> tuple[float, float, float]:
    """By which share the sample period, travel and speed of one more healthy run may differ, by the scatter of these.

    At least by what counts as nothing; where the motion was measured, by a little more, because a machine that wears
    changes its motion. At most by what makes it another kind of motion.
    """
    of = predict(np.array([run.motion for run in runs]), tests)
    least = (NEGLIGIBLE, *[NEGLIGIBLE if all(run.commanded for run in runs) else SMALL] * 2)
    period, travel, speed = (float(np.clip(_scatter(of.part([k])), least[k], PART)) for k in range(3))
    return period, travel, speed


def _scatter(of: Prediction) -> float:
    """By which share of its mean a healthy run may differ in one number (``CONTRADICTED`` standard deviations)."""
    spread = float(of.spread[0])
    if not spread > 0.0:
        return 0.0
    times = stats.t.isf(stats.norm.sf(CONTRADICTED), of.degrees_of_freedom)
    return float(times) * spread / float(of.mean[0])


def alike(mine: float, theirs: float) -> bool:
    """Whether a run's sample period, travel or speed is of the same kind as another's, within a quarter (``PART``)."""
    return abs(mine - theirs) <= PART * theirs
