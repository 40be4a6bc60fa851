"""Histories of a unit's numbers from recording to recording: which have left their healthy band, and their trend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ema_bench_replay.checked_yaml import Checker, read_yaml
from ema_bench_replay.errors import InputError

from ..criteria import NEGLIGIBLE, PART
from ..health.change_point import ChangePoint, change_point
from ..health.drift import Drift, drift
from ..health.false_alarms import FALSE_ALARM_OF_HISTORY
from ..health.remaining_life import Margin, RemainingLife, margin, remaining_life
from .angles import is_angle, is_known, like_path
from .healthy import BY_DEFAULT, Healthy
from .results import DONE
from .units import Unit

FEWEST_HEALTHY = 4
"""Minimum number of healthy values, from which their scatter is estimated."""
_DAY = 86400.0  # s
_LEAST_OWN = 1e-4  # least share of the squared standard errors that is not shared: equal values have errors too


@dataclass(frozen=True, eq=False)
class History:
    """One number of a unit: ``values`` (n,) with standard errors (n,) in its SI ``unit``, at rising ``times`` (n,).

    Times are days since the first recording, and the recordings of a day make one value. If not all results are dated,
    a time is the number of results before.
    """

    owner: str
    name: str
    unit: str
    times: np.ndarray
    values: np.ndarray
    errors: np.ndarray
    dated: bool
    healthy: np.ndarray  # (n,) whether a value belongs to the healthy reference
    as_asked: bool  # whether the healthy values are those that the user asked for
    shared: float  # the part of the errors that all recordings of the unit share: it makes no two values differ
    names: tuple[str, ...]  # of the recordings; the first of each day

    @property
    def path(self) -> str:
        """The name used in limits: ``backlash.width``."""
        return f"{self.owner}.{self.name}"

    @property
    def own_errors(self) -> np.ndarray:
        """Standard errors (n,) without the part that all recordings of the unit share."""
        part = 1.0 - self.shared**2 / float(np.mean(self.errors**2))
        return self.errors * np.sqrt(max(part, _LEAST_OWN))


@dataclass(frozen=True, eq=False)
class Outlook:
    """What a history shows: a lasting change, a trend, the distance to a limit and when it is reached.

    None stands for what is not certain.
    """

    history: History
    healthy: float  # the mean of the healthy values
    now: float  # the mean of the last few values
    limit: float | None
    change: ChangePoint | None
    trend: Drift | None
    margin: Margin | None
    life: RemainingLife | None

    @property
    def share(self) -> float | None:
        """The present change of the number, as a share of its healthy value; None for an angle."""
        if self.change is None or self.healthy == 0.0 or is_angle(self.history.path):
            return None
        return (self.now - self.healthy) / abs(self.healthy)

    def as_json(self) -> dict[str, object]:
        """SI units; times in days, or in results if not all are dated; absent numbers are null."""
        of, change, trend = self.history, self.change, self.trend
        return {
            "number": of.path,
            "unit": of.unit,
            "dated": of.dated,
            "times": of.times.tolist(),
            "values": of.values.tolist(),
            "std": of.errors.tolist(),
            "healthy": self.healthy,
            "now": self.now,
            "change": None
            if change is None
            else {
                "size": change.size,
                "std": change.standard_error,
                "since": of.names[change.begin],
                "told_at": of.names[change.alarm],
            },
            "slope": None if trend is None else {"value": trend.slope, "std": trend.slope_error},
            "margin": None if self.margin is None else {"share": self.margin.share, "std": self.margin.standard_error},
            "remaining": None if self.life is None else vars(self.life),
        }


def histories(unit: Unit, healthy: Healthy = BY_DEFAULT) -> list[History]:
    """The numbers of a unit that have a standard error in more than ``FEWEST_HEALTHY`` of its results.

    An angle is followed where it is known: the phase of a wave of no amplitude may be anything. If the healthy results
    are given by a pattern and do not know it, it is left out.
    """
    found: dict[tuple[str, str, str], list[tuple[float | None, float, float, str]]] = {}
    for row in unit.rows:
        if row["status"] != DONE:
            continue
        for held in row["parameters"] or ():
            value, std = held["value"], held["std"]
            if value is None or std is None or not (np.isfinite([value, std]).all() and std > 0.0):
                continue
            if is_angle(f"{held['owner']}.{held['name']}") and not is_known(std):
                continue
            at = None if row["time"] is None else row["time"].timestamp()
            found.setdefault((held["owner"], held["name"], held["unit"]), []).append((at, value, std, row["name"]))
    every = [_history(*path, its, healthy) for path, its in found.items() if len(its) > FEWEST_HEALTHY]
    return [history for history in every if history.as_asked or not is_angle(history.path)]


def _history(
    owner: str, name: str, unit: str, its: Sequence[tuple[float | None, float, float, str]], healthy: Healthy
) -> History:
    days = np.array([np.nan if at is None else at / _DAY for at, *_ in its])
    names = [one[3] for one in its]
    values, errors = (np.array([one[k] for one in its]) for k in (1, 2))
    if is_angle(f"{owner}.{name}"):  # a jump by a whole turn is no change
        values = np.unwrap(values)
    dated = bool(np.isfinite(days).all() and (np.diff(days) >= 0.0).all())
    flags = np.array(healthy.among(names, range(len(names)), FEWEST_HEALTHY))
    repeats = np.zeros(0)
    if dated and len(firsts := np.flatnonzero(np.diff(np.floor(days), prepend=-np.inf))) > FEWEST_HEALTHY:
        repeats = np.diff(values)[np.diff(np.floor(days)) == 0.0]
        days, values, errors = _by_day(firsts, days, values, errors)
        names = [names[first] for first in firsts]
        flags = np.logical_and.reduceat(flags, firsts)
    dated = dated and bool((np.diff(days) > 0.0).all())
    as_asked = healthy == BY_DEFAULT or int(flags.sum()) >= FEWEST_HEALTHY
    if int(flags.sum()) < FEWEST_HEALTHY:
        first = BY_DEFAULT if healthy.pattern else Healthy(FEWEST_HEALTHY)
        flags = np.array(first.among(names, range(len(names)), FEWEST_HEALTHY))
    held = stands_still(values[flags])
    differ = (repeats if len(repeats) else np.diff(values[flags])) / np.sqrt(2.0)
    differing = float(np.mean(errors**2 if held else differ**2))
    shared = float(np.sqrt(max(0.0, float(np.mean(errors**2)) - differing)))
    times = days - days[0] if dated else np.arange(len(its), dtype=float)
    return History(owner, name, unit, times, values, errors, dated, flags, as_asked, shared, tuple(names))


def stands_still(values: np.ndarray) -> bool:
    """Whether values (n,) lie on a bound (no play, no run-out) or at the start value of the fit.

    Then a considerable share of them is the same except for rounding, which never happens in free fits. Such values do
    not show how much free ones differ.
    """
    if len(values) < 2:
        return False
    same = np.isclose(values[:, None], values[None, :], rtol=1e-12, atol=0.0)
    return int(same.sum(axis=0).max()) > max(1.0, PART * len(values))


def _by_day(
    firsts: np.ndarray, days: np.ndarray, values: np.ndarray, errors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means over the recordings of each day; ``firsts`` are the indices of the first recording of each day.

    Recordings of one day are not independent evidence about other days, so a mean has the error of a single recording.
    """
    counts = np.diff(firsts, append=len(days))
    weights = errors**-2.0
    sums = np.add.reduceat(weights, firsts)
    means = [np.add.reduceat(weights * of, firsts) / sums for of in (days, values)]
    return means[0], means[1], np.sqrt(counts / sums)


def outlook(of: History, limit: float | None = None, false_alarm: float = FALSE_ALARM_OF_HISTORY) -> Outlook:
    """What a history shows, compared with its healthy values.

    ``false_alarm`` is the rate, per value, of changes that are reported by chance.
    """
    level = _mean(of.values[of.healthy], of.errors[of.healthy])
    change = _change(of, false_alarm)
    trend = drift(of.times, of.values, of.errors)
    return Outlook(
        of,
        level,
        _mean(of.values[-FEWEST_HEALTHY:], of.errors[-FEWEST_HEALTHY:]),
        limit,
        change,
        trend if trend.is_trend else None,
        None if limit is None or limit == level else margin(trend, level, limit),
        None if limit is None else remaining_life(trend, limit, limit_error=of.shared, healthy=level),
    )


def _change(of: History, false_alarm: float) -> ChangePoint | None:
    """The first lasting change among the values that are not healthy, in the order of their times.

    Values recorded before the first healthy one are left out: the unit may have been repaired since.
    """
    begun = np.flatnonzero(of.healthy | np.logical_or.accumulate(of.healthy))
    order = begun[np.argsort(~of.healthy[begun], kind="stable")]
    count = int(of.healthy.sum())
    if count == len(order) or count < FEWEST_HEALTHY:
        return None
    found = change_point(of.values[order], of.own_errors[order], count, false_alarm)
    if found is None:
        return None
    alarm, begin, earliest, latest = order[[found.alarm, found.begin, found.earliest, found.latest]].tolist()
    return replace(found, alarm=alarm, begin=begin, earliest=earliest, latest=latest)


def _mean(values: np.ndarray, errors: np.ndarray) -> float:
    """Mean of values (n,), weighted by their standard errors (n,)."""
    return float(np.average(values, weights=errors**-2.0))


def outlooks(unit: Unit, limits: Mapping[str, float], healthy: Healthy = BY_DEFAULT) -> list[Outlook]:
    """The outlooks of all histories of a unit, those that changed most in their standard errors first.

    By chance, one in 1 / FALSE_ALARM_OF_HISTORY results shows a change of any number; the numbers share that rate. Of a
    number that is a negligible part of its kind, neither a change nor a trend is told, unless it has a limit.
    """
    held = histories(unit, healthy)
    rate = FALSE_ALARM_OF_HISTORY / max(len(held), 1)
    found = [outlook(history, limits.get(history.path), rate) for history in held]
    found = [replace(one, change=None, trend=None) if _is_trivial(one, found) else one for one in found]
    return sorted(found, key=lambda one: -abs(one.change.distance) if one.change else 0.0)


def _is_trivial(look: Outlook, looks: Sequence[Outlook]) -> bool:
    """Whether a number has no limit and is negligible beside the same number of like effects: one of two dry frictions.

    What a fit gives to the one, it takes from the other.
    """

    def size(of: Outlook) -> float:
        return max(abs(of.healthy), abs(of.now))

    like = [one for one in looks if like_path(one.history.path) == like_path(look.history.path)]
    return look.limit is None and size(look) < NEGLIGIBLE * sum(map(size, like))


def read_limits(file: Path | None) -> dict[str, float]:
    """Limits by ``owner.name``, in SI units, from a YAML file. Raises InputError if it holds anything else."""
    if file is None:
        return {}
    content, _ = read_yaml(file)
    check = Checker(file)
    held = check.mapping(content, "", required=())
    if not held:
        raise InputError(f"{file}: holds no limits; write lines as: backlash.width: 0.004")
    return {str(path): check.number(value, str(path)) for path, value in held.items()}
