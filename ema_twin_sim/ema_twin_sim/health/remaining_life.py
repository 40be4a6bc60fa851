"""Prognosis: the distance to a limit, and when a trend reaches it.

The probability that the limit is passed at a time is the probability that the trend lies beyond it at that time, with
the errors of level and slope and the uncertainty of the onset. Its quantiles are the interval (for one onset, they are
Fieller's). If the values show no trend towards the limit, no remaining life is given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize, stats

from .drift import Drift

_BEYOND = 1e4  # times the history's length: longer counts as never


@dataclass(frozen=True)
class Margin:
    """The share of the way from a healthy value to a limit that is left."""

    share: float  # 1: healthy; 0: at the limit
    standard_error: float


@dataclass(frozen=True)
class RemainingLife:
    """When a limit is reached, counted from the history's last time, in the unit of its times."""

    median: float
    earliest: float  # with ``latest``: the interval that holds it with ``probability``
    latest: float  # infinite if the trend may be too flat ever to reach it
    probability: float


def margin(found: Drift, healthy: float, limit: float) -> Margin:
    """The margin left between the present value and a limit; ``healthy`` and ``limit`` are in the values' unit."""
    value, error = found.now()
    return Margin((limit - value) / (limit - healthy), error / abs(limit - healthy))


def remaining_life(
    found: Drift, limit: float, probability: float = 0.9, limit_error: float = 0.0, healthy: float | None = None
) -> RemainingLife | None:
    """When the values reach a limit that they drift to; None if they show no trend towards it, or one too slow for it.

    Which side of the limit is beyond it follows from the ``healthy`` value or, if that is not given, from the present
    one. If ``healthy`` is given and the values have passed the limit with the interval's probability, no life is left,
    whatever the trend. ``limit_error`` is the standard error that all values share: it does not affect the differences
    between them, only their distance to the limit.
    """
    side = float(np.sign(limit - (found.now()[0] if healthy is None else healthy))) or 1.0
    tail = 0.5 * (1.0 - probability)
    if healthy is not None and passed(found, limit, limit_error, side, 0.0) >= 1.0 - tail:
        return RemainingLife(0.0, 0.0, 0.0, probability)
    if not found.is_trend or side * found.slope <= 0.0:
        return None
    moments = [_when(found, limit, limit_error, side, share) for share in (tail, 0.5, 1.0 - tail)]
    if not np.isfinite(moments[0]):
        return None
    return RemainingLife(moments[1], moments[0], moments[2], probability)


def passed(found: Drift, limit: float, limit_error: float, side: float, after: float) -> float:
    """Probability that the limit is passed at ``after`` the last time."""
    values, errors = found.at(float(found.times[-1]) + after)
    distance = side * (values - limit) / np.hypot(errors, limit_error)
    return float(found.weights @ stats.t.cdf(distance, found.freedom))


def _when(found: Drift, limit: float, limit_error: float, side: float, share: float) -> float:
    """The time after the last one at which the limit is passed with the probability ``share``."""
    low, high = 0.0, float(found.times[-1] - found.times[0])
    longest = _BEYOND * high
    if passed(found, limit, limit_error, side, low) >= share:
        return 0.0
    while passed(found, limit, limit_error, side, high) < share:
        low, high = high, 2.0 * high
        if high > longest:
            return np.inf
    return float(optimize.brentq(lambda after: passed(found, limit, limit_error, side, after) - share, low, high))
