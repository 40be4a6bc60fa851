"""The gear ratio that both positions show in all recordings of a machine, and how well they show it.

An output behind play rests on one flank or the other, as its load says. Where a load goes with the angle, as gravity
does, the flank does too, and a slope takes the play for a part of the ratio. So only ways are compared over which the
output stays on its flank, in short pieces of the recordings: those over which it changes flanks are far off the others,
and count nothing. A late encoder, friction's wind-up and an angle error are fitted beside the ratio. What an unseen
load winds up in proportion to the angle stays in it, and is told as part of the uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import CONTRADICTED, NEARLY_ALL, PART, SIGNIFICANT, SMALL
from .ratio_of_positions import ALIKE
from .robust_regression import bulk_weights
from .smoothing import gaussian, smooth

_WINDOWS = (0.1, 0.03, 0.01, 0.003)  # of a recording's samples, over which ways are compared
_SMOOTHED = 10.0  # samples
_AT_ENDS = 40  # samples at either end that this smoothing distorts by more than half a per cent; shortest way
_FEWEST = 400  # samples
_MOST = 6000  # ways of a recording, which overlap
_BLOCKS = 8  # of a recording, each left out once for the standard error
_ROUND = 1.0 / 3.0  # of a turn of the output, beyond which an angle error can be distinguished from a slope
_BEND, _DIRECTION = 2, 3  # columns of the motor's acceleration and of the sign of its speed


@dataclass(frozen=True)
class ShownRatio:
    """A gear ratio, negative if the shafts turn against each other, and how uncertain it is; NaN if that is unknown."""

    value: float
    uncertainty: float = math.nan
    """Largest likely deviation: by chance, and by an unseen load that winds up as much as is left between encoders."""


def ratio_of_recordings(recordings: Sequence[Recording], near: float) -> ShownRatio:
    """The gear ratio by all recordings, beginning at one that is ``near``; that one if they tell no other."""
    both = _of_both(recordings)
    shown = _shown(both, near)
    if shown is None:
        return ShownRatio(near)
    factors, error = shown
    shift = min(_left_over(each, factors) for each in both)
    return ShownRatio(float(factors[0]), CONTRADICTED * error + shift)


def flanks_apart(recordings: Sequence[Recording], near: float) -> float | None:
    """How far the output moves [rad] from one flank of the play to the other, whatever load moves it; None if unknown.

    The positions differ by one of two values, beside what a ratio that is ``near`` and a late encoder part.
    """
    both = _of_both(recordings)
    shown = _shown(both, near)
    if shown is None:
        return None
    factors = shown[0].copy()
    factors[_DIRECTION] = 0.0  # where friction chooses the flank, the direction tells which
    apart = [_between_levels(left) for each in both if len(left := _left(each, factors))]
    return max(apart, default=0.0) / abs(near) or None


def _of_both(recordings: Sequence[Recording]) -> list[Recording]:
    return [r for r in recordings if r.has("motor_position", "output_position") and not r.of_points]


def _shown(recordings: Sequence[Recording], near: float) -> tuple[np.ndarray, float] | None:
    """The factors of the columns by the ways that tell the ratio best, and its standard error; None if none does."""
    found = [shown for window in _WINDOWS if (shown := _over(window, recordings, near)) is not None]
    return min(found, key=lambda shown: shown[1], default=None)


def _columns(recording: Recording, *, turned: bool) -> np.ndarray:
    """What a motor's position (n,) may consist of (n, k): the output's, its lateness and friction, an angle error.

    The columns of an angle error are zero unless the output ``turned`` far enough to show one; rows near the ends of
    the recording are NaN.
    """
    motor, output = (recording.signals[name] for name in ("motor_position", "output_position"))
    step, bend = (smooth(motor, gaussian(_SMOOTHED, 1.0, order)) for order in (1, 2))
    waves = (np.sin(output), np.cos(output)) if turned else (np.zeros_like(output),) * 2
    columns = np.stack([output, step, bend, np.sign(step), *waves], axis=1)
    columns[:_AT_ENDS] = columns[-_AT_ENDS:] = np.nan
    return columns


def _follows(recording: Recording, ratio: float) -> np.ndarray:
    """Whether the output follows (n,) the moving motor at about the ratio: while play is crossed it does not."""
    step, follows = (
        smooth(recording.signals[name], gaussian(_SMOOTHED, 1.0, 1)) for name in ("motor_position", "output_position")
    )
    fastest = np.nanmax(np.abs(step), initial=0.0)
    moves: np.ndarray = (np.abs(step) > SMALL * fastest) & (np.abs(ratio * follows - step) < PART * np.abs(step))
    return moves


def _over(window: float, recordings: Sequence[Recording], near: float) -> tuple[np.ndarray, float] | None:
    """The factors of the columns by ways over this part of each recording, and the ratio's standard error; or None."""
    turned = max(map(_travel, recordings), default=0.0) > _ROUND * 2.0 * math.pi
    blocks = [block for each in recordings for block in _ways(each, window, near, turned=turned)]
    if not blocks:
        return None
    factors, errors = _fitted(blocks, [])
    if not (abs(factors[_BEND]) > SIGNIFICANT * errors[_BEND] and _alike(factors[0], near)):
        factors, errors = _fitted(blocks, [_BEND])  # in a steady swing it is the position over again
    return (factors, float(errors[0])) if math.isfinite(errors[0]) and _alike(factors[0], near) else None


def _alike(ratio: float, near: float) -> bool:
    return abs(ratio / near - 1.0) < ALIKE


def _ways(recording: Recording, window: float, near: float, *, turned: bool) -> list[tuple[np.ndarray, np.ndarray]]:
    """Blocks of ways of the columns (n, k) and of the motor (n,) over a part of the recording; none if too few."""
    lag = int(window * len(recording))
    if lag < _AT_ENDS:
        return []
    columns, motor = _columns(recording, turned=turned), recording.signals["motor_position"]
    columns[~_follows(recording, near)] = np.nan
    parts, way = columns[lag:] - columns[:-lag], motor[lag:] - motor[:-lag]
    whole = np.isfinite(parts).all(axis=1) & np.isfinite(way)
    if whole.sum() < _FEWEST:
        return []
    every = max(1, int(whole.sum()) // _MOST)
    parts, way = parts[whole][::every], way[whole][::every]
    return list(zip(np.array_split(parts, _BLOCKS), np.array_split(way, _BLOCKS), strict=True))


def _fitted(blocks: list[tuple[np.ndarray, np.ndarray]], without: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Factors of the columns (k,) and their standard errors (k,), by leaving each block out once (jackknife)."""
    parts, way = (np.concatenate(each) for each in zip(*blocks, strict=True))
    size = np.abs(parts).max(axis=0)
    kept = [k for k in range(len(size)) if size[k] > 0.0 and k not in without]
    scaled = parts[:, kept] / size[kept]
    factors, weights = bulk_weights(scaled, way)
    ends = np.cumsum([len(block) for _, block in blocks])[:-1]
    each = [
        (columns.T @ columns, columns.T @ values)
        for columns, values in zip(
            np.split(scaled * weights[:, None], ends), np.split(way * weights, ends), strict=True
        )
    ]
    whole, right = sum(square for square, _ in each), sum(side for _, side in each)
    left_out = np.array([np.linalg.lstsq(whole - square, right - side, rcond=None)[0] for square, side in each])
    n = len(blocks)
    spread = np.sqrt((n - 1.0) / n * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0))
    all_factors, errors = np.zeros(len(size)), np.full(len(size), np.inf)
    all_factors[kept], errors[kept] = factors / size[kept], spread / size[kept]
    return all_factors, errors


def _left_over(recording: Recording, factors: np.ndarray) -> float:
    """Range of what the factors leave of the motor's position over the output's travel, without a few samples."""
    travel = _travel(recording)
    if not travel > 0.0:
        return math.inf
    left = _left(recording, factors)
    return float(np.ptp(np.quantile(left, (1.0 - NEARLY_ALL, NEARLY_ALL)))) / travel if len(left) else math.inf


def _left(recording: Recording, factors: np.ndarray) -> np.ndarray:
    """What the factors leave of the motor's position (m,), where it is known."""
    turned = bool(np.any(factors[-2:]))
    left = recording.signals["motor_position"] - _columns(recording, turned=turned) @ factors
    known: np.ndarray = left[np.isfinite(left)]
    return known


def _between_levels(values: np.ndarray) -> float:
    """Distance between the two levels at which the values (m,) stay; 0 if they do not stay at two."""
    low, high = np.quantile(values, (1.0 - NEARLY_ALL, NEARLY_ALL))
    above = values > 0.5 * (low + high)
    if above.all() or not above.any():
        return 0.0
    middles = [float(np.median(part)) for part in (values[above], values[~above])]
    within = [1.4826 * np.median(np.abs(values[of] - m)) for of, m in zip((above, ~above), middles, strict=True)]
    apart = middles[0] - middles[1]
    return apart if max(within) < PART * apart else 0.0


def _travel(recording: Recording) -> float:
    """From end to end of the output's position [rad]."""
    output = recording.signals["output_position"]
    output = output[np.isfinite(output)]
    return float(np.ptp(output)) if len(output) else 0.0
