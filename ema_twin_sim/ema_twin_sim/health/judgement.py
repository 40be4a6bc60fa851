"""Judge the health of a unit, run by run, in the order of ISO 13374: acquisition, manipulation, state, health.

Prognosis over many runs is in ``change_point``, ``drift`` and ``remaining_life``; the last sentence of the words is the
advice.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..criteria import CONTRADICTED, LIKELY, NEGLIGIBLE, PART, SIGNIFICANT
from ..listing import listed
from .acquisition import Acquisition
from .baseline import Baseline, tails
from .comparable import not_comparable
from .families import Family, Ranked, rank
from .features import Feature, Features
from .motion_record import MotionRecord
from .run_features import RunFeatures, run_features

_WORDS = {
    "friction": "effort in steady motion",
    "load": "effort that does not reverse with the motion",
    "rest_effort": "effort at rest",
    "roughness": "roughness of steady motion",
    "fast_roughness": "fast roughness",
    "slow_roughness": "slow roughness",
    "rest_hunting": "hunting at rest",
    "wave_depth": "wave that repeats with the position",
    "bump": "largest local bump",
    "lag": "lag of the position while starting",
    "breakaway": "effort to break away",
    "settling": "effort while settling after a stroke",
    "lost_motion": "lost motion between the encoders",
}
_REASONS = {**_WORDS, "wave_both_ways": "wave at the same place in both directions"}
"""Words for the features that speak for a family. ``wave_both_ways`` is a square, so its change is not printed."""
_ADVICE = {
    Family.FRICTION_UP: "Look at lubricant, seals and bearings.",
    Family.PRELOAD_UP: "Look at what sets the preload: balls, nut, bearings and their alignment.",
    Family.FRICTION_DOWN: "Look at the preload of nut and bearings, and at the temperature.",
    Family.PLAY: "Measure the play by hand; look at nut, coupling and bearings.",
    Family.LOCAL_DAMAGE: "Look at tracks, balls and teeth for pits.",
    Family.LOAD: "Look at what hangs on the output.",
    Family.UNKNOWN: "Check what was changed on the unit and in its test.",
}


@dataclass(frozen=True)
class Change:
    """A feature of a run and its healthy value."""

    name: str
    value: float
    unit: str
    healthy: float  # in the same unit
    standard_deviations: float  # of one more healthy run of one more test


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

    @property
    def unknown(self) -> bool:
        """Whether something changed that no family of damage is named for."""
        return self.family is Family.UNKNOWN


def judge(record: MotionRecord, baseline: Baseline) -> HealthJudgement:
    """Judge one run of the unit that a baseline was learnt from."""
    return judge_run(run_features(record, baseline.wavelength, baseline.unsigned), baseline)


def judge_run(run: RunFeatures, baseline: Baseline) -> HealthJudgement:
    """Judge one run whose features were computed with the wavelength of the baseline."""
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
    all_changes = {c.name: c.standard_deviations for c in changes}
    known = {name: off for name, off in all_changes.items() if not (acquisition.unsigned and name == "load")}
    beside = baseline.beside(features)
    ranked = rank(known, beside)
    family, why = _named(ranked, all_changes, features, baseline, acquisition) if detected else (None, ())
    return HealthJudgement(
        run.name, run.test, acquisition, told, changes, detected, baseline.false_alarm,
        float(np.nanmax(found / limits)), family,
        ranked[0].probability if ranked and family not in (None, Family.UNKNOWN) else 0.0,
        ranked, (*acquisition.findings, *_words(changes, detected, baseline), *why), beside,
    )  # fmt: skip


def named_together(judgements: Sequence[HealthJudgement]) -> tuple[Ranked, ...]:
    """Rank the families by the mean change of those of several runs that were called off, such as of one test or stage.

    What differs between the runs averages out. What differs between tests does not, so this names a family, but detects
    nothing.
    """
    off = [one for one in judgements if one.detected]
    magnitude = any(one.acquisition.unsigned for one in judgements)
    changes = _mean([{c.name: c.standard_deviations for c in one.changes} for one in off])
    if magnitude:
        changes.pop("load", None)
    return rank(changes, _mean([one.beside for one in off]))


def _mean(runs: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Mean of each feature over those runs that have it."""
    names = sorted({name for run in runs for name in run})
    return {name: float(np.mean([run[name] for run in runs if name in run])) for name in names}


def _named(
    ranked: tuple[Ranked, ...],
    changes: Mapping[str, float],
    features: Features,
    baseline: Baseline,
    acquisition: Acquisition,
) -> tuple[Family, tuple[str, ...]]:
    """The family of a change that was detected, and why, in words."""
    if not acquisition.effort_usable:
        return Family.UNKNOWN, ("No fault family is given, because the effort is not usable.",)
    apart = np.subtract(features.sides, baseline.sides)
    uneven = abs(changes.get("load", 0.0)) > SIGNIFICANT
    if acquisition.unsigned and uneven and apart[0] * apart[1] < 0.0:
        return Family.UNKNOWN, (
            "The effort rises in one direction and falls in the other; an unsigned effort does not show whether load "
            "or friction changed. Record a signed current.",
        )
    if not ranked or ranked[0].family is Family.UNKNOWN or ranked[0].explained <= 0.0:
        return Family.UNKNOWN, (f"{_unexplained(ranked, changes)} {_ADVICE[Family.UNKNOWN]}",)
    best = ranked[0]
    reasons = " and ".join(_REASONS[name] for name in best.because[:2])
    sentence = (
        f"This is {best.family.value} (probability {best.probability:.0%} among the known families and none of them), "
        f"by {reasons}."
    )
    rivals = [other for other in ranked[1:] if other.probability > 1.0 - best.probability or other.probability > PART]
    if rivals:
        other = "none of them" if rivals[0].family is Family.UNKNOWN else rivals[0].family.value
        sentence += f" Alternatively {other} ({rivals[0].probability:.0%})."
    return best.family, (f"{sentence} {_ADVICE[best.family]}",)


def _unexplained(ranked: tuple[Ranked, ...], changes: Mapping[str, float]) -> str:
    """What changed that none of the families explains, in a sentence."""
    left = ranked[0].because if ranked and ranked[0].family is Family.UNKNOWN else ()
    by = f": {_REASONS[left[0]]} by {changes[left[0]]:+.1f} standard deviations" if left else ""
    return f"Something changed that none of the families of damage explains{by}."


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
    return f"{'; '.join(f'{_WORDS[change.name]} {_by(change)}' for change in shown)} ({by} standard deviations)"


def _shown(changes: Sequence[Change]) -> list[Change]:
    """The largest changes that are likely more than chance, three at most."""
    told = sorted((c for c in changes if c.name in _WORDS), key=lambda c: -abs(c.standard_deviations))
    return [c for c in told if abs(c.standard_deviations) > LIKELY][:3]


def _by(change: Change) -> str:
    if not change.healthy > NEGLIGIBLE * abs(change.value):
        return f"is {change.value:.3g} {change.unit}, was {change.healthy:.3g} {change.unit}"
    share = 100.0 * (change.value / change.healthy - 1.0)
    whole = f"{abs(share):.0f}"
    return f"is {whole if len(whole) > 1 else f'{abs(share):.2g}'}% {'above' if share > 0.0 else 'below'} the healthy"


def _change(name: str, feature: Feature, baseline: Baseline, off: float) -> Change:
    mean = float(baseline.prediction.mean[baseline.features.index(name)])
    healthy = math.exp(mean) if feature.logarithm else mean * (baseline.scale if feature.scales else 1.0)
    value = math.exp(feature.value) if feature.logarithm else feature.value
    return Change(name, value, feature.unit, healthy, float(off))


def _not_judged(run: RunFeatures, baseline: Baseline, words: tuple[str, ...]) -> HealthJudgement:
    return HealthJudgement(
        run.name, run.test, run.acquisition, {}, (), None, baseline.false_alarm, np.nan, None, 0.0, (), words
    )
