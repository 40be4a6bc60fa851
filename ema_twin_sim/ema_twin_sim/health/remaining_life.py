"""Prognosis: the distance to a limit, and when a trend gets there.

The chance that the limit is passed at a time is that of the line at that time to lie beyond it, with the errors of
level and slope and the doubt about the onset; its quantiles are the interval (of one onset, they are Fieller's). Where
the values show no trend towards the limit there is no remaining life to be told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from .drift import Drift

_BEYOND = 1e4  # times the history's length: longer is for ever
_HALVINGS = 30


@dataclass(frozen=True)
class Margin:
    """How much of the way from a healthy value to a limit is left."""

    share: float  # 1: healthy; 0: at the limit
    standard_error: float


@dataclass(frozen=True)
class RemainingLife:
    """When a limit is reached, in the unit of the history's times from its last on."""

    median: float
    earliest: float  # limits of an interval that holds it with that probability
    latest: float  # infinite where the trend may be too flat ever to get there
    probability: float


def margin(found: Drift, healthy: float, limit: float) -> Margin:
    """What is left of the way from a healthy value to a limit, both in the values' unit."""
    value, error = found.now()
    return Margin((limit - value) / (limit - healthy), error / abs(limit - healthy))


def remaining_life(
    found: Drift, limit: float, probability: float = 0.9, limit_error: float = 0.0, healthy: float | None = None
) -> RemainingLife | None:
    """When the values reach a limit that they are drifting to, or None where they show no trend to it.

    The limit lies on its side of the ``healthy`` value, or where that is not given of the last: what has passed it, by
    the interval's probability, has no life left, wherever it goes.
    The standard error of the limit is what all values share: they tell each other, and not the limit, more exactly.
    """
    side = float(np.sign(limit - (found.now()[0] if healthy is None else healthy))) or 1.0
    tail = 0.5 * (1.0 - probability)
    if healthy is not None and passed(found, limit, limit_error, side, 0.0) >= 1.0 - tail:
        return RemainingLife(0.0, 0.0, 0.0, probability)
    if not found.is_trend or side * found.slope <= 0.0:
        return None
    moments = [_when(found, limit, limit_error, side, share) for share in (tail, 0.5, 1.0 - tail)]
    return RemainingLife(moments[1], moments[0], moments[2], probability)


def passed(found: Drift, limit: float, limit_error: float, side: float, after: float) -> float:
    """Chance that the limit is passed so long after the last time."""
    values, errors = found.at(float(found.times[-1]) + after)
    distance = side * (values - limit) / np.hypot(errors, limit_error)
    return float(found.weights @ stats.t.cdf(distance, found.freedom))


def _when(found: Drift, limit: float, limit_error: float, side: float, share: float) -> float:
    """The time after the last at which the limit is passed with that chance."""
    low, high = 0.0, float(found.times[-1] - found.times[0])
    longest = _BEYOND * high
    if passed(found, limit, limit_error, side, low) >= share:
        return 0.0
    while passed(found, limit, limit_error, side, high) < share:
        low, high = high, 2.0 * high
        if high > longest:
            return np.inf
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if passed(found, limit, limit_error, side, middle) >= share else (middle, high)
    return high
