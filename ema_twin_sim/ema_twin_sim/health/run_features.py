"""The features of a run for the health judgement; with them it can be judged again without its samples."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..criteria import PART
from .acquisition import Acquisition, judge_acquisition
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
    unsigned: bool  # whether the features are those of a magnitude
    motion: tuple[float, float, float]  # sample period s, travel m or rad, top speed m/s or rad/s
    position_unit: str
    effort_unit: str


def run_features(record: MotionRecord, wavelength: float, unsigned: bool | None = None) -> RunFeatures:
    """Compute the features of a run. ``wavelength`` is in the position's unit, NaN for none.

    ``unsigned`` says whether the effort is a magnitude; None: decided from the run itself.
    """
    acquisition = judge_acquisition(record)
    taken = acquisition.unsigned if unsigned is None else unsigned
    features, motion = None, (np.nan, np.nan, np.nan)
    if acquisition.usable:
        phases = phases_of(record)
        features = features_of(record, wavelength, taken)
        motion = float(np.median(np.diff(record.time))), phases.travel, phases.top_speed
        if np.isfinite(wavelength) and "wave_depth" not in features.values:
            acquisition = replace(acquisition, findings=(*acquisition.findings, _too_short(phases, record, wavelength)))
    return RunFeatures(
        record.name, record.test, acquisition, features, wavelength, taken, motion, record.position_unit,
        record.effort_unit,
    )  # fmt: skip


def _too_short(phases: Phases, record: MotionRecord, wavelength: float) -> str:
    strokes = phases.strokes(1) + phases.strokes(-1)
    longest = max(float(np.ptp(record.position[stroke.steady])) for stroke in strokes)
    return (
        "The wave that repeats with the position is not judged: the longest stroke is "
        f"{longest / wavelength:.2g} times its wavelength of {wavelength:.3g} {record.position_unit}. Record longer "
        "strokes, or correct the wavelength."
    )


def same_motion(one: RunFeatures, other: RunFeatures) -> bool:
    """Whether two runs have the same kind of motion, so that their features compare."""
    return one.unsigned == other.unsigned and all(map(alike, one.motion, other.motion))


def alike(mine: float, theirs: float) -> bool:
    """Whether a run's sample period, travel or speed agrees with that of others, within a quarter (``PART``)."""
    return abs(mine - theirs) <= PART * theirs
