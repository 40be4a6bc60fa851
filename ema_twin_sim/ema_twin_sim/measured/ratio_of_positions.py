"""The gear ratio that the positions of motor and output show."""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import PART, SMALL
from .robust_regression import bulk_regression
from .smoothing import gaussian, smooth

ALIKE = 0.02  # relative deviation up to which two ratios are alike
_FEWEST_TO_REFINE = 400  # samples
_SMOOTHED = 10.0  # samples
_AT_ENDS = 40  # samples at either end that this smoothing distorts by more than half a per cent
_ROUND = 1.0 / 3.0  # of a turn of the output, beyond which an angle error can be distinguished from a slope
_MOVING = 0.3  # of the largest distance
_FEWEST = 10
_WINDOWS = (0.1, 0.061)  # of a recording's samples, over which the motions of the shafts are compared


def ratio_of_positions(recording: Recording) -> float | None:
    """The gear ratio that both positions show, negative if they turn against each other; None if they show none."""
    if not recording.has("motor_position", "output_position"):
        return None
    motor, output = _farthest_apart(recording)
    both = np.isfinite(motor) & np.isfinite(output) & (output != 0.0)
    far = both & (np.abs(motor) > _MOVING * np.abs(motor[both]).max(initial=0.0))
    if far.sum() < _FEWEST:
        return None
    ratio = float(np.median(motor[far] / output[far]))
    if recording.of_points or len(recording) < _FEWEST_TO_REFINE:
        return ratio
    return _beside_lags(recording, ratio)


def _farthest_apart(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Ways [rad] of motor and output over a part of the recording, at each of its starts (k,).

    Of several lengths the one over which the motor goes farthest: a periodic motion goes nowhere in a whole period.
    """
    lags = [max(1, int(window * len(recording))) for window in _WINDOWS]
    ways = [
        tuple(recording.signals[n][lag:] - recording.signals[n][:-lag] for n in ("motor_position", "output_position"))
        for lag in lags
    ]
    motor, output = max(ways, key=lambda way: float(np.nanmean(np.abs(way[0]))) if np.isfinite(way[0]).any() else 0.0)
    return motor, output


def _beside_lags(recording: Recording, ratio: float) -> float:
    """The ratio of both positions, fitted together with a delay of the output, play, wind-up and an off-centre encoder.

    The regression is robust and uses motion only, and only where the output follows at about the ratio of their
    speeds: at rest, and while play is crossed, it may be anywhere. If it tells another ratio than most of the speeds,
    these decide, or else the ``ratio`` of the ways.
    """
    motor, output = (recording.signals[name] for name in ("motor_position", "output_position"))
    step, bend = (smooth(motor, gaussian(_SMOOTHED, 1.0, order)) for order in (1, 2))
    follows = smooth(output, gaussian(_SMOOTHED, 1.0, 1))
    fast = (np.abs(step) > _MOVING * np.nanmax(np.abs(step))) & (np.abs(ratio * follows) > SMALL * np.abs(step))
    slopes = np.sort(step[fast] / follows[fast]) if fast.sum() >= _FEWEST_TO_REFINE else np.array([ratio])
    of_speeds = float(np.median(slopes))
    columns = np.stack([output, step, np.sign(step), bend, np.ones(len(step))], axis=1)
    if np.ptp(output[np.isfinite(output)]) > _ROUND * 2.0 * math.pi:
        columns = np.concatenate([columns, np.sin(output)[:, None], np.cos(output)[:, None]], axis=1)
    columns[:_AT_ENDS] = columns[-_AT_ENDS:] = np.nan
    whole = np.isfinite(columns).all(axis=1) & np.isfinite(motor)
    whole &= (np.abs(step) > SMALL * np.nanmax(np.abs(step))) & (
        np.abs(of_speeds * follows - step) < PART * np.abs(step)
    )
    if whole.sum() < _FEWEST_TO_REFINE:
        return ratio
    found = float(bulk_regression(columns[whole], motor[whole])[0])
    return found if abs(found / of_speeds - 1.0) < ALIKE else _most_alike(slopes, ratio)


def _most_alike(slopes: np.ndarray, otherwise: float) -> float:
    """The middle of the half of all slopes (n,), sorted, that differs least; ``otherwise`` unless these are alike.

    An output that is thrown through wide play in each braking follows at the gear's ratio for the rest of its way.
    """
    half = len(slopes) // 2
    first = int(np.argmin(slopes[half:] - slopes[: len(slopes) - half]))
    low, high = float(slopes[first]), float(slopes[first + half])
    return 0.5 * (low + high) if abs(high - low) < ALIKE * abs(low) and len(slopes) > 1 else otherwise
