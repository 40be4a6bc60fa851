"""Whether a position that no header explains belongs to the speed beside it: whether it goes where the speed goes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import LIKELY, MOSTLY, PART
from ..measured.way_by_speed import FEWEST, travelled_by_speed
from ..reading_noise import reading_noise

_PARTS = (20, 40, 100)  # of a recording, over each of which the ways are compared


def not_summed(recordings: Sequence[Recording]) -> str:
    """Why a motor position is no position if it looks like the counts since the last sample; else empty."""
    judged = [recording for recording in recordings if _shows_motion(recording)]
    if not judged or any(_goes_with_speed(recording) for recording in judged):
        return ""
    if any(_alike(_summed(_position(r)), travelled_by_speed(r), beside_means=True) < MOSTLY for r in judged):
        return ""
    return (
        "not used: it looks like the counts since the last sample, since its sum goes as the speed says and it does "
        "not itself (to use it, write its sum into the column)"
    )


def unlike_speed(recordings: Sequence[Recording]) -> str:
    """Why a motor position is none if it has nothing to do with the speed in any recording; else empty."""
    judged = [recording for recording in recordings if _shows_motion(recording)]
    if not judged or any(_goes_with_speed(recording) for recording in judged):
        return ""
    return "not used: it has nothing in common with the integral of the speed"


def _goes_with_speed(recording: Recording) -> bool:
    return _alike(_position(recording), travelled_by_speed(recording)) >= PART


def _shows_motion(recording: Recording) -> bool:
    """Whether a recording has both, and a speed that changes by more than its readings do."""
    if recording.of_points or not recording.has("speed", "motor_position") or len(recording) < FEWEST:
        return False
    speed = recording.signals["speed"][np.isfinite(recording.signals["speed"])]
    return len(speed) >= FEWEST and float(np.std(speed)) > LIKELY * reading_noise(speed)


def _position(recording: Recording) -> np.ndarray:
    """The position (n,) as it was read, from the counter's own zero."""
    origin = recording.motor_angle_origin
    return recording.signals["motor_position"] + (0.0 if math.isnan(origin) else origin)


def _summed(steps: np.ndarray) -> np.ndarray:
    """The sum (n,) up to each sample, NaN where a step is; the missing step itself is left out."""
    missing = np.isnan(steps)
    return np.where(missing, np.nan, np.cumsum(np.where(missing, 0.0, steps)))


def _alike(one: np.ndarray, other: np.ndarray, *, beside_means: bool = False) -> float:
    """How far two motions (n,) go the same ways, 0 to 1, over parts of the length at which they are most alike.

    ``beside_means`` leaves out what both go on average: the sum of a constant goes on and on.
    """
    best = 0.0
    for parts in _PARTS:
        lag = max(1, len(one) // parts)
        ways = one[lag:] - one[:-lag], other[lag:] - other[:-lag]
        known = np.isfinite(ways[0]) & np.isfinite(ways[1])
        if known.sum() < FEWEST:
            continue
        first, second = (way[known] - (way[known].mean() if beside_means else 0.0) for way in ways)
        size = math.sqrt(float(first @ first) * float(second @ second))
        best = max(best, abs(float(first @ second)) / size if size > 0.0 else 0.0)
    return best
