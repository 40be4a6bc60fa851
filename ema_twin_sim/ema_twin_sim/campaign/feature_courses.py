"""Courses of the health features that deviate most in a unit, from test to test, with their trend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta

import numpy as np

from ..criteria import SIGNIFICANT
from ..health.drift import drift, like_a_step
from .histories import FEWEST_HEALTHY, History, Outlook, outlook
from .unit_health import JudgedTest, UnitHealth
from .units import Unit

_MOST = 3
"""Number of features that are followed."""
_OWNER = "health"


def feature_courses(unit: Unit, health: UnitHealth | None) -> list[Outlook]:
    """The features that deviate most in the last deviating test, over all tests, healthy ones included.

    Values are in standard deviations of one more healthy test, so each has a standard error of 1.
    """
    if health is None or not health.off:
        return []
    place = {row["name"]: k for k, row in enumerate(unit.rows)}
    tests = sorted((*health.reference, *health.tests), key=lambda test: place[test.runs[0].name])
    found = [_history(unit, name, tests, health) for name in _deviating(health.off[-1])]
    return [_since_change(outlook(history)) for history in found if len(history.values) > FEWEST_HEALTHY]


def _since_change(look: Outlook) -> Outlook:
    """With the trend of the tests since the change or, if these are few, of all, unless one step explains it as well.

    Without dates, tests stand in the order of their names, which may be conditions and not times: then there is none.
    """
    of = look.history
    if not of.dated:
        return replace(look, change=None, trend=None)
    since = 0 if look.change is None else look.change.begin
    if len(of.values) - since <= FEWEST_HEALTHY:
        since = 0
    its = of.times[since:], of.values[since:], of.errors[since:]
    if since:
        later = drift(*its)
        look = replace(look, trend=later if later.is_trend else None)
    return look if look.trend is None or not like_a_step(*its) else replace(look, trend=None)


def _deviating(test: JudgedTest) -> list[str]:
    """Names of the features that are significantly off, the farthest first; the farthest of all if none is.

    The phasor of a wave is left out: its depth says by how much the wave has grown.
    """
    names = dict.fromkeys(change.name for run in test.runs for change in run.changes)
    of = {name: abs(_mean(test, name)) for name in names if not name.startswith("wave_") or name == "wave_depth"}
    order = sorted(of, key=lambda name: -of[name])
    return [name for name in order if of[name] > SIGNIFICANT][:_MOST] or order[:1]


def _mean(test: JudgedTest, name: str) -> float:
    """The mean of a feature over the recordings of a test, in standard deviations; NaN if none has it."""
    held = [change.standard_deviations for run in test.runs for change in run.changes if change.name == name]
    return float(np.mean(held)) if held else float("nan")


def _history(unit: Unit, name: str, tests: Sequence[JudgedTest], health: UnitHealth) -> History:
    of = [(test, value) for test in tests if np.isfinite(value := _mean(test, name))]
    when = {row["name"]: row["time"] for row in unit.rows}
    starts = [when[test.runs[0].name] for test, _ in of]
    days = np.array([np.nan if None in (at, starts[0]) else (at - starts[0]) / timedelta(days=1) for at in starts])
    dated = bool(np.isfinite(days).all() and (np.diff(days) > 0.0).all())
    return History(
        _OWNER,
        name,
        "1",
        days if dated else np.arange(len(of), dtype=float),
        np.array([value for _, value in of]),
        np.ones(len(of)),
        dated,
        np.array([test in health.reference for test, _ in of]),
        as_asked=True,
        shared=0.0,
        names=tuple(test.name for test, _ in of),
    )
