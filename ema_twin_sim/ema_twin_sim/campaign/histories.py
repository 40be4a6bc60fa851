"""Histories: how the numbers of a unit go from recording to recording, which have left their band, and where to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import stats

from ema_bench_replay.checked_yaml import Checker, read_yaml
from ema_bench_replay.errors import InputError

from ..criteria import NEARLY_ALL
from ..health.change_point import ChangePoint, change_point
from ..health.drift import Drift, drift
from ..health.remaining_life import Margin, RemainingLife, margin, remaining_life
from .healthy import BY_DEFAULT, Healthy
from .results import DONE
from .units import Unit

FEWEST_HEALTHY = 4
"""Values that tell how much healthy ones scatter."""
_DAY = 86400.0  # s


@dataclass(frozen=True, eq=False)
class History:
    """One number of a unit: ``values`` (n,) with standard errors (n,) in its SI ``unit``, at rising ``times`` (n,).

    Times are days since the first; or how many results came before, where not all are dated.
    """

    owner: str
    name: str
    unit: str
    times: np.ndarray
    values: np.ndarray
    errors: np.ndarray
    dated: bool
    names: tuple[str, ...]  # of the recordings

    @property
    def path(self) -> str:
        """As limits name it: ``backlash.width``."""
        return f"{self.owner}.{self.name}"


@dataclass(frozen=True, eq=False)
class Outlook:
    """What a history says: a lasting change, a trend, how far a limit is and when it is reached; None: nothing sure."""

    history: History
    healthy: float  # the mean of the first values
    now: float  # that of the last few
    limit: float | None
    change: ChangePoint | None
    trend: Drift | None
    margin: Margin | None
    life: RemainingLife | None

    @property
    def share(self) -> float | None:
        """By what share of its healthy value the number has changed, now."""
        return None if self.change is None or self.healthy == 0.0 else (self.now - self.healthy) / abs(self.healthy)

    def as_json(self) -> dict[str, object]:
        """SI units; times in days, or in results where not all are dated; absent numbers are null."""
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
            else {"size": change.size, "std": change.standard_error, "since": of.names[change.begin]},
            "slope": None if trend is None else {"value": trend.slope, "std": trend.slope_error},
            "margin": None if self.margin is None else {"share": self.margin.share, "std": self.margin.standard_error},
            "remaining": None if self.life is None else vars(self.life),
        }


def histories(unit: Unit) -> list[History]:
    """The numbers of a unit that have a standard error in enough of its results to be followed."""
    found: dict[tuple[str, str, str], list[tuple[float | None, float, float, str]]] = {}
    for row in unit.rows:
        if row["status"] != DONE:
            continue
        for held in row["parameters"] or ():
            value, std = held["value"], held["std"]
            if value is None or std is None or not (np.isfinite([value, std]).all() and std > 0.0):
                continue
            at = None if row["time"] is None else row["time"].timestamp()
            found.setdefault((held["owner"], held["name"], held["unit"]), []).append((at, value, std, row["name"]))
    return [_history(*path, its) for path, its in found.items() if len(its) > FEWEST_HEALTHY]


def _history(owner: str, name: str, unit: str, its: Sequence[tuple[float | None, float, float, str]]) -> History:
    days = np.array([np.nan if at is None else at / _DAY for at, *_ in its])
    dated = bool(np.isfinite(days).all() and (np.diff(days) > 0.0).all())
    times = days - days[0] if dated else np.arange(len(its), dtype=float)
    values, errors = (np.array([one[k] for one in its]) for k in (1, 2))
    return History(owner, name, unit, times, values, errors, dated, tuple(one[3] for one in its))


def outlook(of: History, limit: float | None = None, healthy: Healthy = BY_DEFAULT) -> Outlook:
    """What a history says, held against its first values: the ``healthy`` ones."""
    count = healthy.first(of.names, FEWEST_HEALTHY)
    level = _mean(of.values[:count], of.errors[:count])
    errors = of.errors * _share_that_differs(of.values[:count], of.errors[:count], level)
    change = change_point(of.values, errors, count) if len(of.values) > count else None
    trend = drift(of.times, of.values, errors)
    return Outlook(
        of,
        level,
        _mean(of.values[-FEWEST_HEALTHY:], of.errors[-FEWEST_HEALTHY:]),
        limit,
        change,
        trend if trend.is_trend else None,
        None if limit is None or limit == level else margin(trend, level, limit),
        None if limit is None else remaining_life(trend, limit),
    )


def _mean(values: np.ndarray, errors: np.ndarray) -> float:
    """Of values (n,), each counted by its standard error (n,)."""
    return float(np.average(values, weights=errors**-2.0))


def _share_that_differs(values: np.ndarray, errors: np.ndarray, level: float) -> float:
    """What of standard errors (n,) tells two healthy values apart, at the most: one, or less.

    What recordings of a unit share, a constant's tolerance above all, is in the standard error of each and in no
    difference of two. By how much values scatter about their ``level`` bounds what is left.
    """
    scatter = float(np.sum(((values - level) / errors) ** 2))
    return min(1.0, float(np.sqrt(scatter / stats.chi2.ppf(1.0 - NEARLY_ALL, len(values) - 1))))


def outlooks(unit: Unit, limits: Mapping[str, float], healthy: Healthy = BY_DEFAULT) -> list[Outlook]:
    """What all histories of a unit say, those that changed most in their standard errors first."""
    found = [outlook(history, limits.get(history.path), healthy) for history in histories(unit)]
    return sorted(found, key=lambda one: -abs(one.change.distance) if one.change else 0.0)


def read_limits(file: Path | None) -> dict[str, float]:
    """Limits by ``owner.name``, in SI units, from a YAML file. Raises InputError where it holds anything else."""
    if file is None:
        return {}
    content, _ = read_yaml(file)
    check = Checker(file)
    held = check.mapping(content, "", required=())
    if not held:
        raise InputError(f"{file}: holds no limits; write lines as: backlash.width: 0.004")
    return {str(path): check.number(value, str(path)) for path, value in held.items()}
