"""The way that a speed implies, beside the position: whether they agree, are a factor apart, or one stands still."""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.long_columns import pieces
from ema_bench_replay.recording import Recording

from ..criteria import LIKELY, MOSTLY, NEGLIGIBLE, PART, SMALL, TOO_MUCH
from ..reading_noise import reading_noise

WINDOW = 0.1  # own s over which displacements are compared
FEWEST = 30  # samples needed


def way_by_speed(recording: Recording, lag: int = 0) -> float | None:
    """Motor displacement over the displacement that the speed implies; None if that ratio is not steady.

    Displacements are taken over ``lag`` samples; 0: over ``WINDOW``, for a recording in own units.
    """
    if not recording.has("speed", "motor_position"):
        return None
    lag = lag or lag_of(recording)
    position, travelled = without_pauses(recording, recording.signals["motor_position"], travelled_by_speed(recording))
    return steady_factor(position[lag:] - position[:-lag], travelled[lag:] - travelled[:-lag])


def without_pauses(recording: Recording, *ways: np.ndarray) -> list[np.ndarray]:
    """The motions (n,) of a recording without what they go while nothing was recorded for long."""
    return without_long_steps(recording.time, TOO_MUCH * lag_of(recording) * recording.sample_period, *ways)


def without_long_steps(time: np.ndarray, longest: float, *ways: np.ndarray) -> list[np.ndarray]:
    """Motions (n,) without what they go in steps of ``time`` (n,) that are longer than the ``longest`` that counts.

    Nobody knows what a pause hides: the speed may change in it, and a position that starts again after each turn does
    not tell how many turns it went. Missing values beside a pause belong to it: what counts is what both sides know.
    """
    pauses = np.diff(time) > longest
    known = np.flatnonzero(np.isfinite(ways).all(axis=0))
    if not pauses.any() or not len(known):
        return [*ways]
    before = np.concatenate([[0], np.cumsum(pauses)])[known]  # how many pauses come before each row that is known
    across = np.flatnonzero(np.diff(before))
    found = []
    for way in ways:
        hidden = np.zeros(len(way))
        hidden[known[across + 1]] = way[known[across + 1]] - way[known[across]]
        found.append(way - np.cumsum(hidden))
    return found


def standing_position(recording: Recording) -> float | None:
    """The way [rad] that the speed implies if the motor position stands still meanwhile; None if it does not.

    A speed that is steady but for its readings implies none: it may have an offset. A position in a wrong unit, or that
    of the output, follows the speed, however little.
    """
    if not recording.has("speed", "motor_position") or recording.of_points:
        return None
    way = _travel(recording.signals["speed"], summed=True) * recording.sample_period  # nobody knows what a pause hides
    if not _travel(recording.signals["motor_position"]) <= NEGLIGIBLE * way:
        return None  # as of nearly all recordings; what follows takes memory as long ones have
    position, speed = (recording.signals[name] for name in ("motor_position", "speed"))
    speed = speed[np.isfinite(speed)]
    if min(np.isfinite(position).sum(), len(speed)) < FEWEST or way_by_speed(recording) is not None:
        return None
    levels = np.diff(np.unique(speed))
    reading = max(reading_noise(speed), float(levels.min(initial=math.inf)) / math.sqrt(12.0) if len(levels) else 0.0)
    if float(np.std(speed)) <= LIKELY * reading:
        return None
    known = np.isfinite(position)
    both = np.corrcoef(position[known], travelled_by_speed(recording)[known]) if np.ptp(position[known]) > 0.0 else None
    return way if both is None or abs(both[0, 1]) < MOSTLY else None


def _travel(values: np.ndarray, *, summed: bool = False) -> float:
    """From end to end of the known values (n,), or of their sum as they come; a long recording piece by piece."""
    least, most, total = math.inf, -math.inf, 0.0
    for rows in pieces(len(values)):
        part = values[rows]
        part = part[np.isfinite(part)]
        if not len(part):
            continue
        if summed:
            part = total + np.cumsum(part)
            total = float(part[-1])
        least, most = min(least, float(part.min())), max(most, float(part.max()))
    return max(most - least, 0.0)


def lag_of(recording: Recording) -> int:
    """Number of samples over which displacements are taken."""
    return max(1, round(WINDOW / recording.sample_period)) if len(recording) > 1 else 1


def travelled_by_speed(recording: Recording) -> np.ndarray:
    """Displacement (n,) [rad] implied by the speed, bridging missing samples; NaN if there is no speed at all."""
    speed = recording.signals["speed"]
    known = np.isfinite(speed)
    if not known.any():
        return np.full(len(speed), np.nan)
    speed = np.interp(recording.time, recording.time[known], speed[known])
    return np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(recording.time))])


def steady_factor(values: np.ndarray, expected: np.ndarray, fewest: int = FEWEST) -> float | None:
    """Ratio of the values (n,) to the expected ones (n,); None if it is not steady.

    At least ``fewest`` of the expected values must be large.
    """
    both = np.isfinite(values) & np.isfinite(expected)
    values, expected = values[both], expected[both]
    large = np.abs(expected) > PART * np.abs(expected).max(initial=0.0)
    if large.sum() < fewest:
        return None
    ratios = values[large] / expected[large]
    middle = float(np.median(ratios))
    spread = 1.4826 * float(np.median(np.abs(ratios - middle)))
    return middle if spread < SMALL * abs(middle) else None
