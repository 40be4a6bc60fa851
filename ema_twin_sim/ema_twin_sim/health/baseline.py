"""State: what a healthy unit's runs look like, learnt from runs declared healthy, and how far another run is off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from ema_bench_replay.errors import InputError

from ..criteria import CONTRADICTED, MOSTLY, NEARLY_ALL, NEGLIGIBLE
from .acquisition import Extent, judge_acquisition
from .between_tests import Prediction, predict
from .block_limit import block_limit
from .disturbance import tells_more
from .encoders import NEARLY_REPEATABLE
from .false_alarms import FALSE_ALARM
from .features import Feature, Features, stroke_efforts
from .motion_record import MotionRecord
from .run_features import RunFeatures, mostly_unsigned, motion_limits, run_features
from .wave import found_wavelength

LEVELS = ("friction", "roughness", "rest_hunting", "settling")
"""How much effort the unit takes and how it scatters: judged together. The degrees of freedom follow from the variances
between tests and between runs."""
WAVES = ("wave_forward_cos", "wave_forward_sin", "wave_backward_cos", "wave_backward_sin")
"""Where it takes that effort: judged together likewise. All eight features in one block would need twice as many tests.
"""
RUNNING = LEVELS + WAVES
ALONE = ("load", "lag", "breakaway", "bump", "lost_motion", "encoder_reach", "encoder_scatter", "encoder_drift")
"""Its load, how it starts, local damage, and play between two encoders: each judged by itself, with the number of tests
minus one as degrees of freedom, because these features depend on how a run began and have outliers."""
SHOWN = ("fast_roughness", "slow_roughness", "wave_depth", "wave_both_ways")
"""Features that help to name a change but raise no alarm: they are parts of what is judged already."""
FEWEST_TESTS = 3
_VANISHING = 1e-7  # of the unit's own effort or travel, or in a logarithm: a feature that varies less is simulated


@dataclass(frozen=True)
class BlockLimit:
    """One block of features, and the tail probability below which it raises an alarm."""

    features: tuple[str, ...]
    limit: float  # natural logarithm


@dataclass(frozen=True, eq=False)
class Baseline:
    """A unit's healthy state."""

    features: tuple[str, ...]
    prediction: Prediction  # of the features; those that scale with the effort are divided by the unit's own effort
    scale: float  # the healthy effort against the motion, A or N m
    wavelength: float  # m or rad, of what repeats with the position; NaN if nothing does
    blocks: tuple[BlockLimit, ...]
    false_alarm: float
    false_alarms_left_out: float  # share of the healthy runs that a baseline of the other tests calls off at that rate
    tests: int
    runs: int
    unsigned: bool
    freed: bool  # whether the waves are without what errors of the position explain
    motion: tuple[float, float, float]  # sample period s, travel m or rad, top speed m/s or rad/s
    motion_limits: tuple[float, float, float]  # by which share each may differ in a run that compares
    extents: tuple[Extent, ...]  # of the healthy runs
    still: Mapping[str, tuple[float, float]]  # features that hardly vary: their mean, and what counts as hardly
    warnings: tuple[str, ...]

    def vector(self, features: Features) -> np.ndarray:
        """The features of a run (p,), NaN for those that it lacks."""
        return _vector(features.told(self.freed), self.features, self.scale)

    def healthy(self, name: str) -> tuple[float, float]:
        """Mean and standard deviation of a feature, as compared: in times of the unit's own effort if it scales."""
        row = self.features.index(name)
        return float(self.prediction.mean[row]), float(self.prediction.spread[row])

    def beside(self, features: Features) -> dict[str, float]:
        """How far a run is off in the features that hardly vary, in times of what counts as hardly."""
        values = _vector(features.told(self.freed), tuple(self.still), self.scale)
        return {name: (value - mean) / hardly for value, (name, (mean, hardly)) in zip(values, self.still.items(),
                strict=True) if np.isfinite(value)}  # fmt: skip


def learn(
    records: Sequence[MotionRecord], *, wavelength: float | None = None, false_alarm: float = FALSE_ALARM
) -> Baseline:
    """Learn the healthy state from healthy runs of three tests or more.

    ``wavelength``, in the position's unit, is the lead of a screw or 2π of a turning shaft; if it is None, it is found
    from the runs. Raises InputError if the runs do not suffice.
    """
    if wavelength is None:
        judged = [(record, judge_acquisition(record)) for record in records]
        fit = [(record, acquisition) for record, acquisition in judged if acquisition.fit_to_learn_from]
        unsigned = mostly_unsigned([acquisition for _, acquisition in fit])
        strokes = [stroke for record, _ in fit for stroke in stroke_efforts(record, unsigned)]
        wavelength = found_wavelength(strokes) if strokes else np.nan
    return learn_from([run_features(record, wavelength) for record in records], false_alarm=false_alarm)


def learn_from(runs: Sequence[RunFeatures], *, false_alarm: float = FALSE_ALARM) -> Baseline:
    """The same from runs whose features were computed before, all with one wavelength.

    Raises InputError if they do not suffice, or do not belong together.
    """
    kept, warnings = [], []
    for run in runs:
        if run.acquisition.fit_to_learn_from:
            kept.append(run)
        else:
            warnings.append(f"{run.name}: not used for the baseline. {' '.join(run.acquisition.findings)}")
    tests = [run.test for run in kept]
    number = len(set(tests))
    if number < FEWEST_TESTS:
        raise InputError(
            f"healthy recordings of {number} tests are too few to estimate how tests differ; give {FEWEST_TESTS}"
        )
    unsigned = mostly_unsigned([run.acquisition for run in kept])
    kept = [run.read_as(unsigned) for run in kept]
    if odd := next((run for run in kept if run.unsigned != unsigned), None):
        raise InputError(f"{odd.name}: {other_sign(odd)}; leave it out of the healthy ones")
    wavelength = kept[0].wavelength
    if not np.array_equal([run.wavelength for run in kept], [wavelength] * len(kept), equal_nan=True):
        raise InputError("healthy recordings were read with several wavelengths; read all of them with one")
    all_features = [run.features for run in kept if run.features is not None]
    freed = _freed(all_features, tests)
    told = [features.told(freed) for features in all_features]
    motions = np.array([run.motion for run in kept])
    travel = float(np.median(motions[:, 1]))
    names = tuple(
        name
        for name in RUNNING + ALONE + SHOWN
        if all(name in values for values in told)
        and (wavelength <= travel or not name.startswith("wave_"))  # a longer wave cannot be told from a trend
    )
    sides = [_mean_known([features.sides[way] for features in all_features]) for way in (0, 1)]
    scale = float(np.nanmax(np.abs(sides)))
    values = np.array([_vector(values, names, scale) for values in told])
    sizes = _sizes(told[0], names, travel)
    moving = [name for name, spread in zip(names, values.std(axis=0) / sizes, strict=True) if spread > _VANISHING]
    still = {
        name: (float(mean), _VANISHING * float(size))
        for name, mean, size in zip(names, values.mean(axis=0), sizes, strict=True)
        if name not in moving
    }
    values = values[:, [names.index(name) for name in moving]]
    judged = [name for name in moving if not (unsigned and name == "load")]  # a magnitude does not show a load
    columns = [moving.index(name) for name in judged]
    # Of what repeats within its rounding, a change below a calibration's has to stay within the limits of chance.
    added = np.array([NEGLIGIBLE / CONTRADICTED if name in NEARLY_REPEATABLE else 0.0 for name in moving])
    blocks, left_out = _limits(judged, values[:, columns], tests, added[columns], false_alarm)
    return Baseline(
        features=tuple(moving),
        prediction=predict(values, tests).with_scatter_added(added),
        scale=scale,
        wavelength=wavelength,
        blocks=blocks,
        false_alarm=false_alarm,
        false_alarms_left_out=left_out,
        tests=number,
        runs=len(kept),
        unsigned=unsigned,
        freed=freed,
        motion=tuple(np.median(motions, axis=0)),
        motion_limits=motion_limits(kept, tests),
        extents=tuple(run.acquisition.extent for run in kept),
        still=still,
        warnings=tuple(warnings),
    )


def other_sign(run: RunFeatures) -> str:
    """A clause on a run whose effort is a magnitude when that of the healthy ones is not, or the other way round."""
    if run.unsigned:
        return "The effort is a magnitude and that of the healthy recordings has a sign"
    return "The effort has a sign and that of the healthy recordings is a magnitude"


def tails(
    prediction: Prediction, names: Sequence[str], blocks: Sequence[Sequence[str]], values: np.ndarray
) -> list[float]:
    """Log tail probability of each block, by those of its features that the run has; NaN if it has none."""
    found = []
    for block in blocks:
        rows = [i for i, name in enumerate(names) if name in block and np.isfinite(values[i])]
        freedom = None if len(block) > 1 else prediction.tests - 1.0
        found.append(prediction.part(rows).tail(values[rows], freedom) if rows else np.nan)
    return found


def _limits(
    names: Sequence[str], values: np.ndarray, tests: Sequence[str], added: np.ndarray, false_alarm: float
) -> tuple[tuple[BlockLimit, ...], float]:
    """The blocks with their limits, and the share of healthy runs beyond a limit.

    The limits are those of the requested rate if healthy runs are distributed as assumed. Each healthy run is judged by
    the baseline of the other tests. If more of them than chance allows are beyond a block's limit, the runs of this
    unit are not normally distributed, and the limit moves to the farthest of them. ``added`` (p,) is the
    scatter that is added to what each baseline knows.
    """
    learnt = predict(values, tests).with_scatter_added(added)
    blocks = _blocks(names, learnt)
    rates = _rates(blocks, false_alarm)
    drawn = [
        block_limit(learnt.part([names.index(name) for name in block]), math.exp(rate)) if len(block) > 1 else rate
        for block, rate in zip(blocks, rates, strict=True)
    ]
    labels = np.asarray(tests)
    left_out = np.zeros((len(values), len(blocks)))
    for test in dict.fromkeys(tests):
        others = labels != test
        prediction = predict(values[others], [name for name in tests if name != test]).with_scatter_added(added)
        for row in np.flatnonzero(~others):
            left_out[row] = tails(prediction, names, blocks, values[row])
    beyond = left_out < np.array(drawn)
    farthest = left_out.min(axis=0)
    unlikely = stats.binom.sf(beyond.sum(axis=0) - 1, len(values), np.exp(rates)) < 1.0 - NEARLY_ALL
    limits = tuple(
        BlockLimit(block, min(limit, float(far)) if odd else limit)
        for block, limit, far, odd in zip(blocks, drawn, farthest, unlikely, strict=True)
    )
    return limits, float(np.mean(beyond.any(axis=1)))


def _blocks(names: Sequence[str], prediction: Prediction) -> list[tuple[str, ...]]:
    """The features that are judged together; each by itself if there are too few tests to know how they correlate."""
    found: list[tuple[str, ...]] = []
    for group in (LEVELS, WAVES):
        rows = [i for i, name in enumerate(names) if name in group]
        block = tuple(names[i] for i in rows)
        enough = prediction.runs > 2 * len(rows) > 0 and prediction.part(rows).degrees_of_freedom >= 2 * len(rows)
        found += [block] if enough else [(name,) for name in block]
    return found + [(name,) for name in ALONE if name in names]


def _rates(blocks: Sequence[Sequence[str]], false_alarm: float) -> list[float]:
    """Log of each block's share of the false alarms; the blocks of ``RUNNING`` together get most of them (MOSTLY)."""
    running = sum(block[0] in RUNNING for block in blocks)
    alone = len(blocks) - running
    share = MOSTLY if alone else 1.0
    return [
        math.log(false_alarm * (share / running if block[0] in RUNNING else (1.0 - share) / alone)) for block in blocks
    ]


def _freed(runs: Sequence[Features], tests: Sequence[str]) -> bool:
    """Whether waves without what errors of the position explain show more, judged by both in healthy runs."""
    plain, freed = ([features.told(flag) for features in runs] for flag in (False, True))
    names = [name for name in WAVES if all(name in values for values in plain)]
    if not names:
        return False
    waves, left = (np.array([[values[name].value for name in names] for values in told]) for told in (plain, freed))
    return tells_more(waves, left, tests)


def _mean_known(values: Sequence[float]) -> float:
    """Mean of those that are known; NaN if none is, as of a direction in which no run moves."""
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else np.nan


def _sizes(values: Mapping[str, Feature], names: Sequence[str], travel: float) -> np.ndarray:
    """Reference (p,) for the scatter of each feature: the travel for lengths or angles, else 1."""
    lengths = [not values[name].of_effort and not values[name].logarithm for name in names]
    return np.where(lengths, travel, 1.0)


def _vector(values: Mapping[str, Feature], names: Sequence[str], scale: float) -> np.ndarray:
    return np.array(
        [
            np.nan if name not in values else values[name].value / (scale if values[name].scales else 1.0)
            for name in names
        ]
    )
