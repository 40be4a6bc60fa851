"""Whether a current, or a torque, looks like a magnitude without sign: never negative in motion both ways.

A load that always pulls the same way, as that of a lift or of a level arm, keeps the sign of a current too. Then
inertia and friction raise the current in one direction and lower it in the other; they raise a magnitude in both, and
where the motion turns round, a magnitude goes down to zero.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import MAY_BE_MAGNITUDES, Recording

from ..criteria import ALL_BUT_SPIKES, CORRELATION, DEPENDS, NEARLY_ALL, NEGLIGIBLE, PART, SMALL
from ..measured.smoothing import gaussian, smooth
from ..measured.way_by_speed import FEWEST

_SMOOTHED = 3.0  # samples
_AT_ENDS = 15  # samples at either end that the smoothing distorts


def unsigned_signals(recordings: Sequence[Recording]) -> frozenset[str]:
    """The signals of the drive that look like magnitudes: in no recording negative, and so in one that shows it."""
    return frozenset(
        signal
        for signal in MAY_BE_MAGNITUDES
        if all(_never_negative(recording, signal) for recording in recordings)
        and any(_looks_unsigned(recording, signal) for recording in recordings)
    )


def _never_negative(recording: Recording, signal: str) -> bool:
    return not recording.has(signal) or not np.nanmin(recording.signals[signal], initial=0.0) < 0.0


def _looks_unsigned(recording: Recording, signal: str) -> bool:
    """Whether a signal without negative values gets near zero, and is better described without direction than with it.

    Instead of the latter it may go down to zero in motion both ways, which no load that keeps the sign allows, or be no
    worse described and the same both ways, as without any friction.
    """
    if recording.of_points or not recording.has(signal) or (found := _motion(recording)) is None:
        return False
    speed, acceleration = found
    values = recording.signals[signal]
    known = np.isfinite(speed) & np.isfinite(acceleration) & np.isfinite(values)
    if known.sum() < FEWEST or not np.ptp(values[known]) > 0.0:
        return False
    known &= np.abs(speed) > SMALL * np.quantile(np.abs(speed[known]), NEARLY_ALL)
    speed, acceleration, values = speed[known], acceleration[known], values[known]
    forward = speed > 0.0
    if min(forward.sum(), (~forward).sum()) < max(FEWEST, SMALL * len(speed)):
        return False
    usual = float(np.median(values))
    if not np.nanquantile(recording.signals[signal], 1.0 - ALL_BUT_SPIKES) < PART * usual:
        return False
    if all(np.mean(values[way] <= NEGLIGIBLE * usual) > NEGLIGIBLE for way in (forward, ~forward)):
        return True
    way = np.sign(speed)
    signed = _left(values, np.stack([np.ones(len(way)), way, speed, acceleration], axis=1))
    unsigned = _left(values, np.stack([np.ones(len(way)), way, way * speed, way * acceleration], axis=1))
    gain = len(values) / CORRELATION * 2.0 * math.log(max(signed, 1e-300) / max(unsigned, 1e-300))
    means = [float(np.mean(values[way])) for way in (forward, ~forward)]
    return gain > (-DEPENDS if abs(means[0] - means[1]) < NEGLIGIBLE * sum(means) else DEPENDS)


def _motion(recording: Recording) -> tuple[np.ndarray, np.ndarray] | None:
    """Speed and acceleration (n,), per sample in any unit; None if the recording has no motion of its own."""
    for order, signal in enumerate(("speed", "motor_position", "output_position")):
        if recording.has(signal):
            first = min(order, 1)
            values = recording.signals[signal]
            found = [smooth(values, gaussian(_SMOOTHED, 1.0, derivative)) for derivative in (first, first + 1)]
            for each in found:
                each[:_AT_ENDS] = each[-_AT_ENDS:] = np.nan
            return found[0], found[1]
    return None


def _left(values: np.ndarray, columns: np.ndarray) -> float:
    """The rms of values (n,) beside the best sum of columns (n, m)."""
    columns = columns / np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
    found, *_ = np.linalg.lstsq(columns, values, rcond=None)
    return float(np.sqrt(np.mean((values - columns @ found) ** 2)))
