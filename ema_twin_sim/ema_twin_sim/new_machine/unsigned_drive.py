"""Whether a current, or a torque, looks like a magnitude without sign: never negative in motion both ways.

A load that always pulls the same way, as that of a lift or of a level arm, keeps the sign of a current too. Then
inertia and friction raise the current in one direction and lower it in the other; they raise a magnitude in both, and
where the motion turns round, a magnitude goes down to zero.

Recordings that go one way each show it together. Their loads may differ, so that only the change within each counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ema_bench_replay.recording import MAY_BE_MAGNITUDES, Recording

from ..criteria import ALL_BUT_SPIKES, CORRELATION, DEPENDS, NEARLY_ALL, NEGLIGIBLE, PART, SMALL
from ..measured.smoothing import gaussian, smooth
from ..measured.way_by_speed import FEWEST

_SMOOTHED = 3.0  # samples
_AT_ENDS = 15  # samples at either end that the smoothing distorts


def unsigned_signals(recordings: Sequence[Recording]) -> frozenset[str]:
    """The signals of the drive that look like magnitudes: in no recording negative, and so in one, or in all together.

    A single negative sample is noise: no drive turns its torque round for one sample.
    """
    return frozenset(
        signal
        for signal in MAY_BE_MAGNITUDES
        if all(_never_negative(recording, signal) for recording in recordings)
        and (
            any(_looks_unsigned(recording, signal) for recording in recordings)
            or _look_unsigned_together(recordings, signal)
        )
    )


def _never_negative(recording: Recording, signal: str) -> bool:
    if not recording.has(signal):
        return True
    negative = recording.signals[signal] < 0.0
    return not (negative[1:] & negative[:-1]).any()


def _looks_unsigned(recording: Recording, signal: str) -> bool:
    """Whether a signal without negative values gets near zero, and is better described without direction than with it.

    Instead of the latter it may go down to zero in motion both ways, which no load that keeps the sign allows, or be no
    worse described and the same both ways, as without any friction.
    """
    moving = _moving(recording, signal)
    if moving is None or not _both_ways(moving.speed):
        return False
    speed, values = moving.speed, moving.values
    forward = speed > 0.0
    usual = float(np.median(values))
    if not np.nanquantile(recording.signals[signal], 1.0 - ALL_BUT_SPIKES) < PART * usual:
        return False
    if all(np.mean(values[way] <= NEGLIGIBLE * usual) > NEGLIGIBLE for way in (forward, ~forward)):
        return True
    gain = _gain(moving, [np.ones(len(speed)), np.sign(speed)]) / CORRELATION
    means = [float(np.mean(values[way])) for way in (forward, ~forward)]
    return gain > (-DEPENDS if abs(means[0] - means[1]) < NEGLIGIBLE * sum(means) else DEPENDS)


def _look_unsigned_together(recordings: Sequence[Recording], signal: str) -> bool:
    """The same of recordings of which each may go one way only, so that each way of each has a load of its own.

    The signal is smoothed like the motion: it may be noisier than what inertia and friction make of it.
    """
    kernel = gaussian(_SMOOTHED, 1.0)
    found = [_moving(recording, signal, kernel) for recording in recordings]
    moving = [each for each in found if each is not None]
    if len(moving) < 2 or not _both_ways(np.concatenate([each.speed for each in moving])):
        return False
    whole = _Moving(*(np.concatenate(parts) for parts in zip(*moving, strict=True)))
    all_values = np.concatenate([recording.signals[signal] for recording in recordings if recording.has(signal)])
    if not np.nanquantile(all_values, 1.0 - ALL_BUT_SPIKES) < PART * float(np.median(whole.values)):
        return False
    number = np.repeat(np.arange(len(moving)), [len(each.speed) for each in moving])
    loads = [(number == k) & (whole.speed * way > 0.0) for k in range(len(moving)) for way in (-1.0, 1.0)]
    rows_as_one = 1.0 / float(kernel @ kernel)
    return _gain(whole, [load.astype(float) for load in loads if load.any()]) / rows_as_one > DEPENDS


class _Moving(NamedTuple):
    """The rows (n,) of a recording in which it moves: speed and acceleration, and a signal of the drive."""

    speed: np.ndarray
    acceleration: np.ndarray
    values: np.ndarray


def _moving(recording: Recording, signal: str, kernel: np.ndarray | None = None) -> _Moving | None:
    """These rows of a recording, its signal smoothed by a ``kernel``; None if they are few, or show nothing."""
    if recording.of_points or not recording.has(signal) or (found := _motion(recording)) is None:
        return None
    speed, acceleration = found
    values = recording.signals[signal] if kernel is None else smooth(recording.signals[signal], kernel)
    known = np.isfinite(speed) & np.isfinite(acceleration) & np.isfinite(values)
    if known.sum() < FEWEST or not np.ptp(values[known]) > 0.0:
        return None
    known &= np.abs(speed) > SMALL * np.quantile(np.abs(speed[known]), NEARLY_ALL)
    return _Moving(speed[known], acceleration[known], values[known])


def _both_ways(speed: np.ndarray) -> bool:
    forward = int((speed > 0.0).sum())
    return min(forward, len(speed) - forward) >= max(FEWEST, SMALL * len(speed))


def _gain(moving: _Moving, loads: Sequence[np.ndarray]) -> float:
    """By how much a magnitude explains the signal better than one with a sign, beside ``loads`` (n,), if rows are
    independent: twice the logarithm of the likelihoods' ratio.
    """
    speed, acceleration, values = moving
    way = np.sign(speed)
    signed = _left(values, np.stack([*loads, speed, acceleration], axis=1))
    unsigned = _left(values, np.stack([*loads, way * speed, way * acceleration], axis=1))
    return len(values) * 2.0 * math.log(max(signed, 1e-300) / max(unsigned, 1e-300))


def _motion(recording: Recording) -> tuple[np.ndarray, np.ndarray] | None:
    """Speed and acceleration (n,), in any unit; None if the recording has no motion of its own."""
    for place, signal in enumerate(("speed", "motor_position", "output_position")):
        if recording.has(signal):
            first = min(place, 1)
            values = recording.signals[signal]
            found = [
                smooth(values, gaussian(_SMOOTHED, 1.0, order)) / recording.sample_period**order
                for order in (first, first + 1)
            ]
            for each in found:
                each[:_AT_ENDS] = each[-_AT_ENDS:] = np.nan
            return found[0], found[1]
    return None


def _left(values: np.ndarray, columns: np.ndarray) -> float:
    """The rms of values (n,) beside the best sum of columns (n, m)."""
    columns = columns / np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
    found, *_ = np.linalg.lstsq(columns, values, rcond=None)
    return float(np.sqrt(np.mean((values - columns @ found) ** 2)))
