"""Judge the health of a unit, run by run, in the order of ISO 13374: acquisition, manipulation, state, health.

Prognosis over many runs is in ``change_point``, ``drift`` and ``remaining_life``; the last sentence of the words is the
advice.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..criteria import CONTRADICTED, LIKELY, NEGLIGIBLE
from ..listing import listed
from .acquisition import Acquisition
from .baseline import Baseline, tails
from .change import Change, mean_changes
from .comparable import not_comparable
from .families import Family, Ranked
from .features import Feature
from .motion_record import MotionRecord
from .naming import WORDS, Naming, agreed, in_words, name_change
from .run_features import RunFeatures, run_features


@dataclass(frozen=True)
class HealthJudgement:
    """The judgement of one run."""

    name: str
    test: str
    acquisition: Acquisition
    features: dict[str, Feature]
    changes: tuple[Change, ...]
    detected: bool | None  # None: not judged
    false_alarm: float  # share of healthy runs that would be called off
    distance: float  # from the baseline, in times the limit's; 1 is the limit, NaN if it was not judged
    family: Family | None  # None: nothing was detected
    sureness: float  # probability among the families and the unknown
    ranked: tuple[Ranked, ...]
    words: tuple[str, ...]
    beside: Mapping[str, float] = field(default_factory=dict)  # changes of features that hardly vary, for ``rank``


def judge(record: MotionRecord, baseline: Baseline) -> HealthJudgement:
    """Judge one run of the unit that a baseline was learnt from."""
    return judge_run(run_features(record, baseline.wavelength), baseline)


def judge_run(run: RunFeatures, baseline: Baseline) -> HealthJudgement:
    """Judge one run whose features were computed with the wavelength of the baseline.

    If it is not certain whether its effort is a magnitude, it is read as that of the healthy runs.
    """
    run = run.read_as(baseline.unsigned)
    acquisition, features = run.acquisition, run.features
    if features is None:
        return _not_judged(run, baseline, acquisition.findings)
    if other := not_comparable(run, baseline):
        return _not_judged(run, baseline, (*acquisition.findings, other))
    told, values = features.told(baseline.freed), baseline.vector(features)
    if not acquisition.effort_usable:
        of_effort = [told[name].of_effort if name in told else True for name in baseline.features]
        values[of_effort] = np.nan
    limits = np.array([block.limit for block in baseline.blocks])
    found = np.array(tails(baseline.prediction, baseline.features, [b.features for b in baseline.blocks], values))
    if not np.isfinite(found).any():
        return _not_judged(run, baseline, acquisition.findings)
    detected = bool((found[np.isfinite(found)] < limits[np.isfinite(found)]).any())
    offs = (values - baseline.prediction.mean) / baseline.prediction.spread
    changes = tuple(_change(name, told[name], baseline, off) for name, off in zip(baseline.features, offs, strict=True)
                    if name in told and math.isfinite(off))  # fmt: skip
    beside = baseline.beside(features)
    naming = name_change(
        {c.name: c for c in changes}, beside, unsigned=acquisition.unsigned, effort_usable=acquisition.effort_usable
    )
    family, why = (naming.family, (naming.sentence,)) if detected else (None, ())
    return HealthJudgement(
        run.name, run.test, acquisition, told, changes, detected, baseline.false_alarm,
        float(np.nanmax(found / limits)), family,
        naming.ranked[0].probability if family not in (None, Family.UNKNOWN) else 0.0,
        naming.ranked, (*acquisition.findings, *_words(changes, detected, baseline), *why), beside,
    )  # fmt: skip


def named_together(judgements: Sequence[HealthJudgement]) -> tuple[Ranked, ...]:
    """Rank the families by the mean change of several runs, such as of one test or stage."""
    return naming_together(judgements).ranked


def naming_together(judgements: Sequence[HealthJudgement]) -> Naming:
    """Name the mean change of those of several runs that were called off, such as of one test or stage.

    What differs between the runs averages out. What differs between tests does not, so this names a family, but detects
    nothing. Runs of another motion were compared with other healthy values, so each motion is named by itself.
    """
    motions: dict[tuple[tuple[str, float], ...], list[HealthJudgement]] = {}
    for one in judgements:
        if one.detected:
            motions.setdefault(tuple((c.name, c.healthy) for c in one.changes), []).append(one)
    return agreed([(_of_one_motion(runs), len(runs)) for runs in motions.values()])


def _of_one_motion(off: Sequence[HealthJudgement]) -> Naming:
    return name_change(
        mean_changes([{c.name: c for c in one.changes} for one in off]),
        _mean([one.beside for one in off]),
        unsigned=any(one.acquisition.unsigned for one in off),
        effort_usable=any(one.acquisition.effort_usable for one in off),
    )


def _mean(runs: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Mean of each number over those runs that have it."""
    names = sorted({name for run in runs for name in run})
    return {name: float(np.mean([run[name] for run in runs if name in run])) for name in names}


def _words(changes: tuple[Change, ...], detected: bool, baseline: Baseline) -> tuple[str, ...]:
    """What changed, the largest change first, in a sentence."""
    if not detected:
        return (f"Healthy: like the {baseline.runs} recordings of {baseline.tests} tests that it is compared with.",)
    shown = _shown(changes)
    sure = ""
    if shown and abs(shown[0].standard_deviations) > CONTRADICTED:
        sure = ", clearly"
    elif shown:
        sure = ", in several features together" if len(shown) > 1 else ", most in one feature"
    return (f"It differs from the healthy recordings{sure}: {changed_words(changes)}.",)


def changed_words(changes: Sequence[Change]) -> str:
    """What changed most in a run that was called off, the largest change first, without a full stop."""
    shown = _shown(changes)
    if not shown:
        return "the wave that repeats with the position has shifted"
    by = listed(f"{change.standard_deviations:+.1f}" for change in shown)
    return f"{'; '.join(f'{WORDS[change.name]} {_by(change)}' for change in shown)} ({by} standard deviations)"


def _shown(changes: Sequence[Change]) -> list[Change]:
    """The largest changes that are likely more than chance, three at most."""
    told = sorted(in_words(changes), key=lambda c: -abs(c.standard_deviations))
    return [c for c in told if abs(c.standard_deviations) > LIKELY][:3]


def _by(change: Change) -> str:
    if not change.healthy > NEGLIGIBLE * abs(change.value):
        return f"is {change.value:.3g} {change.unit}, was {change.healthy:.3g} {change.unit}"
    share = 100.0 * (change.value / change.healthy - 1.0)
    whole = f"{abs(share):.0f}"
    return f"is {whole if len(whole) > 1 else f'{abs(share):.2g}'}% {'above' if share > 0.0 else 'below'} the healthy"


def _change(name: str, feature: Feature, baseline: Baseline, off: float) -> Change:
    mean, scatter = baseline.healthy(name)
    healthy = math.exp(mean) if feature.logarithm else mean * (baseline.scale if feature.scales else 1.0)
    value = math.exp(feature.value) if feature.logarithm else feature.value
    return Change(name, value, feature.unit, healthy, float(off), np.inf if feature.logarithm else mean / scatter)


def _not_judged(run: RunFeatures, baseline: Baseline, words: tuple[str, ...]) -> HealthJudgement:
    return HealthJudgement(
        run.name, run.test, run.acquisition, {}, (), None, baseline.false_alarm, np.nan, None, 0.0, (), words
    )
