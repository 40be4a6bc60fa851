"""Whether a current, or a torque, looks like a magnitude without sign: never negative in motion both ways.

Recordings that go one way each show it together. Their loads may differ, so that only the change within each counts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import MAY_BE_MAGNITUDES, Recording

from ..criteria import CONTRADICTED, DEPENDS
from ..measured.magnitude import (
    SMOOTHED,
    Moving,
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
    noise goes below zero as often as above.
    """
    return frozenset(
        signal
        for signal in MAY_BE_MAGNITUDES
        if all(_never_negative(recording, signal, beyond=CONTRADICTED) for recording in recordings)
        and (
            any(_looks_unsigned(recording, signal) for recording in recordings)
            or _look_unsigned_together(recordings, signal)
        )
    )


def _never_negative(recording: Recording, signal: str, beyond: float = 0.0) -> bool:
    """Whether no two samples after each other are negative, by more than so many times the signal's noise."""
    if not recording.has(signal):
        return True
    values = recording.signals[signal]
    negative = values < (-beyond * polled_noise(values) if beyond else 0.0)
    return not (negative[1:] & negative[:-1]).any()


def _looks_unsigned(recording: Recording, signal: str) -> bool:
    moving = _moving(recording, signal)
    noisy = not _never_negative(recording, signal)
    return moving is not None and looks_like_a_magnitude(moving, recording.signals[signal], noisy=noisy)


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
