"""The noise of a single reading of a smooth signal, from the signal itself."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from ema_bench_replay.recording import Recording

from .criteria import CLEARLY_MORE, NEGLIGIBLE

DEPENDED_ON = ("motor_position", "speed", "load_torque")
"""Signals that a drive's torque depends on at an operating point."""
FEWEST_READINGS = 4  # that have a third difference
HELD = 20  # samples for which a command holds each level at least: a noisy reading changes sooner
FEW = 30  # levels whose differences tell no noise
SEGMENT = 128  # samples whose spectrum is taken at once
FEWEST_SEGMENTS = 8  # with half of each shared with the next: fewer have no median
STRETCH = 0.25  # of the frequencies, over which a spectrum is averaged


def reading_noise(values: np.ndarray) -> float:
    """Standard deviation of the white noise on a smooth signal (n,), by its third differences, robustly.

    What the rounding of the numbers in memory makes is none: an exact command would have noise.
    """
    if len(values) < FEWEST_READINGS:
        return 0.0
    third = np.diff(values, 3)
    noise = float(1.4826 * np.median(np.abs(third - np.median(third))) / np.sqrt(20.0))
    return 0.0 if noise <= np.finfo(float).eps * float(np.abs(values).max()) else noise


def smallest_step(values: np.ndarray, rounding: float = 0.0) -> float:
    """The smallest difference between two readings (n,) of a sensor, in their unit; 0 if they never change.

    Arithmetic with them may part equal readings by a ``rounding``, told as a share of their range: that is no step.
    """
    steps = np.diff(np.unique(values[np.isfinite(values)]))
    return float(np.min(steps, initial=np.inf, where=steps > rounding * steps.sum())) if len(steps) else 0.0


def polled_noise(values: np.ndarray) -> float:
    """The same of a sensor that may be polled faster than it updates, so that it repeats each reading.

    If most third differences are therefore zero, only readings that differ from the one before are used. Of coarse
    readings a file's last digit is left of them, far less than the smallest change. The steps of a staircase are no
    readings.
    """
    noise, changes = reading_noise(values), np.abs(np.diff(values))
    if noise > NEGLIGIBLE * np.min(changes, initial=np.inf, where=changes > 0.0):
        return noise
    return 0.0 if is_staircase(values) else reading_noise(_differing(values))


def reading_step(values: np.ndarray) -> float:
    """The smallest step of a sensor's readings (n,); 0 of a staircase, whose steps are no resolution."""
    return 0.0 if is_staircase(values) else smallest_step(values)


def is_staircase(values: np.ndarray) -> bool:
    """Whether a signal (n,) goes from one exact level to another, as a command of steps does.

    It holds each level for many samples, where noise lets the readings of a sensor dither between two values. Readings
    of a sensor that is logged far more often than it is read are held too: they are many, and smooth or all different.
    What never changes has no steps.
    """
    places = np.flatnonzero(np.diff(values))
    if len(places) == 0 or len(values) < HELD * (len(places) + 1) or np.diff(places).min(initial=HELD) < HELD:
        return False
    levels = _differing(values)
    come_back = 2 * len(np.unique(levels)) <= len(levels)
    return len(levels) <= FEW or (come_back and drowns(reading_noise(levels), levels))


def _differing(values: np.ndarray) -> np.ndarray:
    """Those of the values (n,) that differ from the one before."""
    return values[1:][np.diff(values) != 0.0]


def beside_fast_signal(noise: float, values: np.ndarray) -> float:
    """The ``noise`` that third differences of a signal (n,) tell, or less if they took a fast signal for it.

    They take for noise what changes from sample to sample. Where they tell about as much as the whole signal, its
    spectrum is looked at, in the frequencies and at the times at which it is quietest: a signal is not everywhere.
    """
    if not drowns(noise, values):
        return noise
    quietest = _quietest(values)
    return quietest if 0.0 < quietest * CLEARLY_MORE < noise else noise


def drowns(noise: float, values: np.ndarray) -> bool:
    """Whether a ``noise`` is about as large as all changes of a signal (n,), so that it may be the signal itself."""
    return noise > 0.0 and len(values) > 0 and noise * CLEARLY_MORE > float(np.std(values))


def _quietest(values: np.ndarray) -> float:
    """Standard deviation of the white noise whose spectrum is that of the quietest frequencies; 0 of a short signal.

    The median over time leaves out a frequency that is only passed, as in a sweep. (Of noise, the power at a frequency
    is distributed exponentially, with a median of ln 2 of its mean.)
    """
    starts = np.arange(0, len(values) - SEGMENT + 1, SEGMENT // 2)
    if len(starts) < FEWEST_SEGMENTS:
        return 0.0
    window = np.hanning(SEGMENT + 2)[1:-1]
    segments = np.lib.stride_tricks.sliding_window_view(values, SEGMENT)[starts]
    power = np.abs(np.fft.rfft((segments - segments.mean(axis=1, keepdims=True)) * window, axis=1)) ** 2
    usual = np.median(power, axis=0)[2:-1] / (np.log(2.0) * float(window @ window))
    width = round(STRETCH * len(usual))
    return float(np.sqrt(np.convolve(usual, np.full(width, 1.0 / width), "valid").min()))


def noise_at_points(values: np.ndarray, over: Sequence[np.ndarray]) -> float:
    """The same of values (n,) at operating points, whose rows may come in any order.

    ``over`` are what the values may depend on, (n,) each: in the order in which these rise, one within the other, the
    values are smoothest, and that tells least noise. Few levels of one thing may be equal: zero is no noise.
    """
    orders = [np.arange(len(values)), *(np.lexsort(keys) for keys in permutations(over) if keys)]
    shown = [noise for order in orders if (noise := reading_noise(values[order])) > 0.0]
    return min(shown, default=0.0)


def noise_of_points(recording: Recording, name: str) -> float:
    """The noise of a signal at a recording's operating points, beside all that was recorded of what it depends on."""
    values = recording.signals[name]
    over = [recording.signals[other] for other in DEPENDED_ON if recording.has(other)]
    whole = np.isfinite([values, *over]).all(axis=0)
    return noise_at_points(values[whole], [other[whole] for other in over])
