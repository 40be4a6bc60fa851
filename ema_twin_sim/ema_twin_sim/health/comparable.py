"""Acquisition: does a run compare with the healthy ones? Not if its motion or the unit or sign of its effort differs.

Each of these changes the features by more than wear does, and says nothing of the machine.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from ema_bench_replay.units import units_of

from ..criteria import CONTRADICTED, NEGLIGIBLE, PART, TOO_MUCH
from .baseline import Baseline, other_sign
from .run_features import RunFeatures, alike

_EFFORTS = {
    "A": ("current", "current", "rotary"),
    "N m": ("torque", "motor_torque", "rotary"),
    "N": ("force", "motor_torque", "linear"),
}
"""By the unit of the effort: its name, and the signal and kind of motion whose units it may have."""


def not_comparable(run: RunFeatures, baseline: Baseline) -> str:
    """How a run differs from the healthy ones so that its features do not compare; empty if they do."""
    if run.unsigned != baseline.unsigned:
        return f"{other_sign(run)}; record as the healthy ones were."
    return (
        _other_motion(run, baseline)
        or _other_extent(run, baseline)
        or _other_unit(run, baseline)
        or _turned(run, baseline)
    )


def _other_motion(run: RunFeatures, baseline: Baseline) -> str:
    """A sentence if the sample period, the travel or the speed is another, in this order: a clock explains a speed."""
    units = "s", run.position_unit, f"{run.position_unit}/s"
    whats = "sample period", "travel", "top speed"
    found = zip(whats, units, run.motion, baseline.motion, baseline.motion_limits, strict=True)
    for what, unit, mine, theirs, limit in found:
        share = mine / theirs - 1.0
        if abs(share) > limit:
            return (
                f"The {what} of {mine:.3g} {unit} is {abs(share):.0%} {'above' if share > 0.0 else 'below'} that of "
                f"the healthy recordings ({theirs:.3g} {unit}); repeat their test, or learn another baseline."
            )
    return ""


def unlike(run: RunFeatures, baseline: Baseline) -> tuple[bool, bool, float]:
    """A key that sorts baselines by how unlike a run they are.

    Whether the kind of motion is another, whether the sign of the effort is, and the largest ratio of their motions.
    """
    ratios = [abs(math.log(mine / theirs)) for mine, theirs in zip(run.motion, baseline.motion, strict=True)]
    sign = run.read_as(baseline.unsigned).unsigned != baseline.unsigned
    return not all(map(alike, run.motion, baseline.motion)), sign, max(ratios)


def _other_extent(run: RunFeatures, baseline: Baseline) -> str:
    """A sentence if the run is shorter or longer than every healthy one, or makes fewer or more strokes."""
    mine = run.acquisition.extent
    for what, unit, value, theirs in (
        ("duration", " s", mine.duration, [extent.duration for extent in baseline.extents]),
        ("number of strokes", "", float(mine.strokes), [float(extent.strokes) for extent in baseline.extents]),
    ):
        if not (value > 0.0 and theirs and min(theirs) > 0.0):
            continue  # a live run has neither
        if not (1.0 - PART) * min(theirs) <= value <= (1.0 + PART) * max(theirs):
            nearest = min(theirs) if value < min(theirs) else max(theirs)
            advice = "It may have been cut: repeat" if value < nearest else "Repeat"
            return (
                f"The {what} is {value:.3g}{unit} and that of the healthy recordings {nearest:.3g}{unit}. {advice} "
                "their test, or learn another baseline."
            )
    return ""


def _other_unit(run: RunFeatures, baseline: Baseline) -> str:
    """A sentence if all features of the effort are scaled by one factor, which is the ratio of two of its units."""
    factors = [*_factors(run, baseline)]
    if len(factors) < 2 or run.effort_unit not in _EFFORTS:
        return ""
    factor = abs(factors[0])
    if not factor > 0.0 or not all(alike(abs(one), factor) for one in factors):
        return ""
    name, signal, motion = _EFFORTS[run.effort_unit]
    values = units_of(signal, motion)
    pairs = [(one, other, values[one] / values[other]) for one in values for other in values]
    likely = [
        (one, other, abs(math.log(factor / ratio)))
        for one, other, ratio in pairs
        if max(ratio, 1.0 / ratio) > TOO_MUCH and alike(factor, ratio)
    ]
    if not likely:
        return ""
    nearest = min(off for _, _, off in likely)  # several pairs may have that ratio; those of the first units are usual
    one, other, _ = next(pair for pair in likely if math.isclose(pair[2], nearest, abs_tol=NEGLIGIBLE))
    times = f"{factor:.0f}" if factor > 1.0 / NEGLIGIBLE else f"{factor:.3g}"
    return (
        f"Its efforts are all about {times} times the healthy: is the {name}'s unit {other}, and not {one}? "
        "Correct the unit and read it again."
    )


def _turned(run: RunFeatures, baseline: Baseline) -> str:
    """A sentence if the mean effort against the motion is below zero, when that of the healthy runs is above."""
    assert run.features is not None
    if run.unsigned or "friction" not in baseline.features:
        return ""
    healthy, scatter = baseline.healthy("friction")
    mine, unit = run.features.values["friction"].value, run.effort_unit
    if not (mine < -CONTRADICTED * scatter * baseline.scale and healthy > CONTRADICTED * scatter):
        return ""
    name = _EFFORTS[unit][0] if unit in _EFFORTS else "effort"
    return (
        f"The mean effort against the motion is {mine:.3g} {unit} and was {healthy * baseline.scale:.3g} {unit}, but "
        f"no machine drives itself both ways: is the sign of the {name} or of the position reversed? Correct the sign "
        "and read it again."
    )


def _factors(run: RunFeatures, baseline: Baseline) -> Iterator[float]:
    """By which factor each feature of the effort differs from the healthy one, the mean effort first.

    Features whose scatter in healthy runs hides a factor of ``1 + PART`` are left out.
    """
    assert run.features is not None
    told = run.features.told(baseline.freed)
    for name in baseline.features:
        if name not in told or not told[name].of_effort or told[name].unit in ("1", "%"):
            continue  # a share of the effort itself
        healthy, scatter = baseline.healthy(name)
        if told[name].logarithm:  # geometric mean with the position, which keeps its unit
            if CONTRADICTED * 2.0 * scatter < PART:
                yield math.exp(2.0 * (told[name].value - healthy))
        elif PART * abs(healthy) > CONTRADICTED * scatter:
            yield told[name].value / (healthy * baseline.scale)
