"""The period after which a position starts again, seen in its values, where that is not one turn of a shaft.

Drives that send a position in few bits let it start again at the ends of its range, of ±12.5 rad for instance.
"""

from __future__ import annotations

import math

import numpy as np

from ..criteria import MOSTLY, NEGLIGIBLE, PART

_JUMP = 0.5  # of the range, from which on a step is a jump
_FEWEST = 3  # jumps
_DIGITS = 3  # of a period that is given as a plain number
_MOST_DIGITS = 5  # of any other


def wrap_period(values: np.ndarray, turn: float | None = None) -> float | None:
    """The period in the unit of a position (n,) after which it starts again; None if its jumps are no such starts.

    All jumps are then as long as the whole range, to within the longest ordinary step, and the motion goes on over
    them: before and after, it moves against the jump, up to the end of the range and on from its beginning. Steps that
    are true, a counter that is set back, or runs one after the other, which begin and end at rest, do not do so. A
    signal that is cut off at its ends does not jump.

    A period near a whole number of ``turn``s, or near a plain number, is taken for that. Two jumps may be chance.
    """
    known = values[np.isfinite(values)]
    span = float(np.ptp(known)) if len(known) else 0.0
    steps = np.diff(known)
    jumps = np.abs(steps) > _JUMP * span
    places = np.flatnonzero(jumps)
    if len(places) < _FEWEST or jumps.all():
        return None
    ordinary = float(np.abs(steps[~jumps]).max())
    inner = places[(places > 0) & (places < len(steps) - 1)]
    if ordinary > PART * span or len(inner) < _FEWEST:
        return None
    against = -np.sign(steps[inner])
    before, after = against * steps[inner - 1], against * steps[inner + 1]
    if np.mean(np.minimum(before, after) > NEGLIGIBLE * ordinary) < MOSTLY:
        return None
    periods = np.abs(steps[inner]) + 0.5 * (before + after)
    period = float(np.median(periods))
    if np.abs(periods - period).max() > ordinary or not -ordinary <= period - span <= 2.0 * ordinary:
        return None
    return _usual(period, turn)


def _usual(period: float, turn: float | None) -> float:
    """The whole number of turns, or the plain number, that a period is near to; else the period itself."""
    whole = [] if turn is None else [turn * round(period / turn)]
    for usual in (*whole, _rounded(period, _DIGITS)):
        if abs(period - usual) < NEGLIGIBLE**2 * period:
            return usual
    return _rounded(period, _MOST_DIGITS)


def _rounded(value: float, digits: int) -> float:
    """A positive value to so many digits."""
    return round(value, digits - 1 - math.floor(math.log10(value)))
