"""Whether a current, or a torque, looks like a magnitude without sign: never negative in motion both ways.

Recordings that go one way each show it together. Their loads may differ, so that only the change within each counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import MAY_BE_MAGNITUDES, Recording

from ..criteria import APART, DEPENDS
from ..measured.magnitude import (
    SMOOTHED,
    Moving,
    any_in_a_row,
    both_ways,
    gain_without_sign,
    looks_like_a_magnitude,
    moving_rows,
    near_zero,
)
from ..measured.smoothing import gaussian, smooth
from ..reading_noise import polled_noise


def unsigned_signals(recordings: Sequence[Recording]) -> frozenset[str]:
    """The signals of the drive that look like magnitudes: in no recording negative, and so in one, or in all together.

    A single negative sample is noise: no drive turns its torque round for one sample. Where a magnitude is zero, its
    noise goes below zero as often as above, and a current with a sign stays there.
    """
    return frozenset(
        signal
        for signal in MAY_BE_MAGNITUDES
        if not any(recording.has(signal) and _stays_negative(recording.signals[signal]) for recording in recordings)
        and (
            any(_looks_unsigned(recording, signal) for recording in recordings)
            or _look_unsigned_together(recordings, signal)
        )
    )


def _stays_negative(values: np.ndarray) -> bool:
    """Whether values (n,) are negative in the mean of any stretch, of 2, 4, 8, … of them, by more than its noise."""
    values = values[np.isfinite(values)]
    noise = polled_noise(values)
    after = np.r_[0.0, np.cumsum(np.where(_single(values < 0.0), 0.0, values))]
    lengths = (1 << power for power in range(1, len(values).bit_length()))
    return any(bool((after[n:] - after[:-n] < -APART * noise * math.sqrt(n)).any()) for n in lengths)


def _single(marked: np.ndarray) -> np.ndarray:
    """The ``marked`` ones (n,) that have no marked one beside them."""
    around = np.r_[False, marked, False]
    return marked & ~around[:-2] & ~around[2:]


def _looks_unsigned(recording: Recording, signal: str) -> bool:
    moving = _moving(recording, signal)
    values = recording.signals[signal] if moving is not None else np.empty(0)
    noisy = bool(any_in_a_row(values < 0.0))
    return looks_like_a_magnitude(moving, values, noisy=noisy)


def _look_unsigned_together(recordings: Sequence[Recording], signal: str) -> bool:
    """The same of recordings of which each may go one way only, so that each way of each has a load of its own.

    The signal is smoothed like the motion: it may be noisier than what inertia and friction make of it.
    """
    kernel = gaussian(SMOOTHED, 1.0)
    found = [_moving(recording, signal, kernel) for recording in recordings]
    moving = [each for each in found if each is not None]
    if len(moving) < 2 or not both_ways(np.concatenate([each.speed for each in moving])):
        return False
    whole = Moving(*(np.concatenate(parts) for parts in zip(*moving, strict=True)))
    all_values = np.concatenate([recording.signals[signal] for recording in recordings if recording.has(signal)])
    if not near_zero(all_values, float(np.median(whole.values))):
        return False
    number = np.repeat(np.arange(len(moving)), [len(each.speed) for each in moving])
    loads = [(number == k) & (whole.speed * way > 0.0) for k in range(len(moving)) for way in (-1.0, 1.0)]
    rows_as_one = 1.0 / float(kernel @ kernel)
    return gain_without_sign(whole, [load.astype(float) for load in loads if load.any()]) / rows_as_one > DEPENDS


def _moving(recording: Recording, signal: str, kernel: np.ndarray | None = None) -> Moving | None:
    """The rows of motion of a recording, its signal smoothed by a ``kernel``; None if they are few, or show nothing."""
    place = next((name for name in ("speed", "motor_position", "output_position") if recording.has(name)), None)
    if recording.of_points or not recording.has(signal) or place is None:
        return None
    values = recording.signals[signal] if kernel is None else smooth(recording.signals[signal], kernel)
    return moving_rows(recording.signals[place], recording.sample_period, values, of_speed=place == "speed")
