"""Whether a signal of the drive that is never negative is a magnitude without sign, by how it goes with the motion.

A load that always pulls the same way, as that of a lift or of a level arm, keeps the sign of a current too. Then
inertia and friction raise the current in one direction and lower it in the other; they raise a magnitude in both, and
where the motion turns round, a magnitude goes down to zero.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..criteria import ALL_BUT_SPIKES, CORRELATION, DEPENDS, MOSTLY, NEARLY_ALL, NEGLIGIBLE, PART, SMALL
from .smoothing import gaussian, smooth
from .way_by_speed import FEWEST

SMOOTHED = 3.0  # samples
_AT_ENDS = 15  # samples at either end that the smoothing distorts


class Moving(NamedTuple):
    """The rows (n,) in which a machine moves: its speed and acceleration, and a signal of the drive."""

    speed: np.ndarray
    acceleration: np.ndarray
    values: np.ndarray


def moving_rows(motion: np.ndarray, period: float, values: np.ndarray, of_speed: bool) -> Moving | None:
    """These rows of a position or (``of_speed``) a speed (n,), in any unit, and a signal (n,); None if there are few.

    ``period`` is that of the samples in s. None too if the signal never changes.
    """
    first = 0 if of_speed else 1
    orders = (first, first + 1)
    speed, acceleration = (smooth(motion, gaussian(SMOOTHED, 1.0, order)) / period**order for order in orders)
    for each in (speed, acceleration):
        each[:_AT_ENDS] = each[-_AT_ENDS:] = np.nan
    known = np.isfinite(speed) & np.isfinite(acceleration) & np.isfinite(values)
    if known.sum() < FEWEST or not np.ptp(values[known]) > 0.0:
        return None
    known &= np.abs(speed) > SMALL * np.quantile(np.abs(speed[known]), NEARLY_ALL)
    return Moving(speed[known], acceleration[known], values[known])


def looks_like_a_magnitude(moving: Moving | None, values: np.ndarray, *, noisy: bool = False) -> bool:
    """Whether a signal without negative values gets near zero, and is better described without direction than with it.

    Instead of the latter it may go down to zero in motion both ways, which no load that keeps the sign allows, or be no
    worse described and the same both ways, as without any friction. ``values`` (n,) are all of the signal, also those
    at rest. Of a ``noisy`` one, which noise alone makes negative, neither tells anything, and it is none if it is
    negative in fast motion: noise makes a magnitude negative where the machine rests or turns round.
    """
    if moving is None or not both_ways(moving.speed):
        return False
    forward, usual = moving.speed > 0.0, float(np.median(moving.values))
    if not near_zero(values, usual):
        return False
    if not noisy and all(np.mean(moving.values[way] <= NEGLIGIBLE * usual) > NEGLIGIBLE for way in (forward, ~forward)):
        return True
    gain = gain_without_sign(moving, [np.ones(len(forward)), np.sign(moving.speed)]) / CORRELATION
    if noisy:
        return gain > DEPENDS and not _negative_when_fast(moving)
    means = [float(np.mean(moving.values[way])) for way in (forward, ~forward)]
    return gain > (-DEPENDS if abs(means[0] - means[1]) < NEGLIGIBLE * sum(means) else DEPENDS)


def near_zero(values: np.ndarray, usual: float) -> bool:
    """Whether a signal (n,) gets near zero, beside its ``usual`` size in motion, which may be zero in short moves."""
    return bool(np.nanquantile(values, 1.0 - ALL_BUT_SPIKES) <= PART * usual)


def any_in_a_row(marked: np.ndarray) -> bool:
    """Whether any two after each other are marked, of (n,)."""
    return bool((marked[1:] & marked[:-1]).any())


def _negative_when_fast(moving: Moving) -> bool:
    """Whether two samples after each other are negative at most of the speed that is usual in their direction."""
    speeds = (np.clip(way * moving.speed, 0.0, None) for way in (-1.0, 1.0))
    fast = (speed > MOSTLY * np.quantile(speed[speed > 0.0], NEARLY_ALL) for speed in speeds)
    return any(any_in_a_row((moving.values < 0.0) & rows) for rows in fast)


def both_ways(speed: np.ndarray) -> bool:
    """Whether the rows (n,) move both ways, in more than a few of them each."""
    forward = int((speed > 0.0).sum())
    return min(forward, len(speed) - forward) >= max(FEWEST, SMALL * len(speed))


def gain_without_sign(moving: Moving, loads: Sequence[np.ndarray]) -> float:
    """By how much a magnitude explains the signal better than one with a sign, beside ``loads`` (n,), if rows are
    independent: twice the logarithm of the likelihoods' ratio.
    """
    speed, acceleration, values = moving
    way = np.sign(speed)
    signed = _left(values, np.stack([*loads, speed, acceleration], axis=1))
    unsigned = _left(values, np.stack([*loads, way * speed, way * acceleration], axis=1))
    return len(values) * 2.0 * math.log(max(signed, 1e-300) / max(unsigned, 1e-300))


def _left(values: np.ndarray, columns: np.ndarray) -> float:
    """The rms of values (n,) beside the best sum of columns (n, m)."""
    columns = columns / np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
    found, *_ = np.linalg.lstsq(columns, values, rcond=None)
    return float(np.sqrt(np.mean((values - columns @ found) ** 2)))
