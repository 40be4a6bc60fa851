"""Change points of a feature or a parameter over time, at a given rate of false alarms.

The first values are the baseline. At each later value, the mean of the last 1, 2, 4, … values is compared with that of
the baseline (a generalised likelihood ratio over windows); the error of the difference includes the baseline's own. The
scatter is estimated from the baseline more than from the given standard errors; few baseline values give Student's
tail. The limit is the one whose mean time to a false alarm is the reciprocal of the rate, by Siegmund and Venkatraman,
The Annals of Statistics 23, 1995, equation 2.4. That is for all windows; the fewer windows used here give fewer alarms.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import integrate, optimize, stats

from ema_bench_replay.errors import InputError

from ..criteria import LIKELY
from .false_alarms import FALSE_ALARM_OF_HISTORY

_FEWEST = 4  # baseline values
_BELIEVED = 2.0  # degrees of freedom that the given standard errors count for
_LARGEST = 12.0  # standard errors: no rate needs a higher limit


@dataclass(frozen=True)
class ChangePoint:
    """A lasting change of a level."""

    alarm: int  # index of the value at which it was detected
    begin: int  # likeliest index of the first value after it
    earliest: int  # begins from here to ``latest`` explain the values nearly as well: log-likelihoods are within 2
    latest: int
    size: float  # mean of the values since its begin minus that of the baseline, in their unit
    standard_error: float
    distance: float  # standard errors, at the alarm
    limit: float  # standard errors


def change_point(
    values: np.ndarray, errors: np.ndarray, baseline: int, false_alarm: float = FALSE_ALARM_OF_HISTORY
) -> ChangePoint | None:
    """The first change of the values (n,), with standard errors (n,), after the first ``baseline`` ones; None if none.

    ``false_alarm`` is the rate of false alarms per value. Raises InputError if the baseline is too short.
    """
    values, errors = np.asarray(values, dtype=np.float64), np.asarray(errors, dtype=np.float64)
    if baseline < _FEWEST:
        raise InputError(
            f"a baseline of {baseline} values is too short to estimate the scatter; give {_FEWEST} or more"
        )
    weights = 1.0 / errors[:baseline] ** 2
    mean = float(np.sum(weights * values[:baseline]) / weights.sum())
    scatter = float(np.sum(weights * (values[:baseline] - mean) ** 2))
    widened, freedom = inflation(scatter, baseline - 1)
    limit = alarm_limit(false_alarm)
    as_student = float(stats.t.isf(stats.norm.sf(limit), freedom))
    for last in range(baseline, len(values)):
        for length in _windows(last - baseline + 1):
            rows = slice(last - length + 1, last + 1)
            size, error = _off(values[rows], errors[rows], mean, 1.0 / weights.sum(), widened)
            if abs(size) > as_student * error:
                distance = float(stats.norm.isf(stats.t.sf(abs(size) / error, freedom)))
                return _located(values, errors, baseline, last, mean, 1.0 / weights.sum(), widened, distance, limit)
    return None


def inflation(scatter: float, freedom: float) -> tuple[float, float]:
    """The factor for the standard errors, and the degrees of freedom then, from a sum of squares in those errors.

    The given errors count only as much as a few values (``_BELIEVED``): days differ for reasons that no fit knows, and
    what all recordings of a unit share is in each error but in no difference of two values.
    """
    known = _BELIEVED + freedom
    return float(np.sqrt((_BELIEVED + scatter) / known)), float(known)


@cache
def alarm_limit(false_alarm: float) -> float:
    """Standard errors beyond which a window is an alarm, in either direction; by chance one in 1 / rate values is."""

    def rate(limit: float) -> float:
        overshoot = integrate.quad(lambda x: x * _overshoot(x) ** 2, 0.0, limit)[0]
        return float(np.exp(-0.5 * limit**2) * limit * overshoot * np.sqrt(2.0 / np.pi))

    return float(optimize.brentq(lambda limit: np.log(rate(limit) / false_alarm), 2.0, _LARGEST))


def _overshoot(x: float) -> float:
    """Siegmund's function ν, by his rational approximation (2.8 in that paper's notation)."""
    if x < 1e-4:
        return 1.0
    half = 0.5 * x
    normal = stats.norm
    return float((2.0 / x) * (normal.cdf(half) - 0.5) / (half * normal.cdf(half) + normal.pdf(half)))


def _windows(most: int) -> list[int]:
    """Lengths 1, 2, 4, … up to all values beyond the baseline."""
    return sorted({min(2**power, most) for power in range(most.bit_length() + 1)})


def _off(values: np.ndarray, errors: np.ndarray, mean: float, variance: float, widened: float) -> tuple[float, float]:
    """(size, its standard error) of the difference between a window's mean and the baseline's."""
    weights = errors**-2.0
    total = float(weights.sum())
    return float(values @ weights) / total - mean, widened * (1.0 / total + variance) ** 0.5


def _located(
    values: np.ndarray, errors: np.ndarray, baseline: int, last: int, mean: float, variance: float, widened: float,
    distance: float, limit: float,
) -> ChangePoint:  # fmt: skip
    """The change point of an alarm, with the begin that explains the values best."""
    begins = np.arange(baseline, last + 1)
    gains = []
    for begin in begins:
        weights = 1.0 / (widened * errors[begin : last + 1]) ** 2
        off = values[begin : last + 1] - mean
        gains.append(0.5 * float(np.sum(weights * off)) ** 2 / float(weights.sum()))
    best = int(np.argmax(gains))
    likely = begins[np.array(gains) >= gains[best] - LIKELY]
    rows = slice(int(begins[best]), last + 1)
    size, error = _off(values[rows], errors[rows], mean, variance, widened)
    return ChangePoint(last, int(begins[best]), int(likely.min()), int(likely.max()), size, error, distance, limit)
