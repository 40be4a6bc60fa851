"""What the rows of a table are: samples of one motion, or operating points, at rest or at a constant speed each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.import_map import TIME_UNITS

from ..criteria import ALL_BUT_SPIKES, MOSTLY, NEARLY_ALL, NEGLIGIBLE, PART
from ..measured.consistency import steady_factor
from ..model.constants import CONSTANTS
from .columns import Guesses

_SERIES = 500  # rows; fewer may be operating points, one after the other
_CLOCKED = 2.0  # times the usual step of time, or one over it, within which a clock's steps are


def with_kind_of_rows(guesses: Guesses, numbers: Mapping[str, np.ndarray], said: bool) -> Guesses:
    """The guesses, with rows that are operating points where they are ``said`` to be, or seem so by the ``numbers``.

    Points that were not taken in the order of their time are left without it. Raises InputError where rows without a
    time seem to be samples.
    """
    if said:
        guesses = replace(guesses, of_points=True, points_doubt="")
    elif why := _why_points(guesses, numbers):
        guesses = replace(guesses, of_points=True, points_doubt=why)
    elif guesses.time is None and _is_time_series(guesses, numbers):
        raise InputError(
            "the rows follow each other as samples do; export it too, in a column named 'time [s]' or 'time [ms]'; if "
            "each row is an operating point, at rest or at a constant speed, give --operating-points"
        )
    if guesses.of_points and guesses.time is not None and not (np.diff(numbers[guesses.time.column]) > 0.0).all():
        guesses = replace(guesses, time=None, left=(*guesses.left, guesses.time.column))
    return guesses


def _why_points(guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> str:
    """Why rows that have a time are operating points all the same; empty where they are samples.

    ``numbers`` (n,) are those of each column. No clock sampled them, and either the shaft rested at each though it went
    from one to the next, or they are too far apart to show how a motion goes on.
    """
    if guesses.time is None:
        return ""
    time = numbers[guesses.time.column]
    if not _uneven(time):
        return ""
    known = _by_signal(guesses, numbers)
    if _rested(known):
        return "the rows follow no clock, and the speed is zero at each"
    longest = CONSTANTS["sensors.sample_period"].upper
    unit = guesses.time.unit
    if unit is not None and float(np.median(np.diff(time))) * TIME_UNITS[unit] * 1e-9 > longest:
        return f"the rows follow no clock, and are more than {longest:g} s apart"
    return ""


def _is_time_series(guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether rows without a time follow each other as samples do, and are no operating points.

    What moves then changes slowly, and a position goes by what the speed beside it makes in a row. Of a position alone,
    one that goes by the same step each time is one that was set; or that turned steadily, which is no other thing.
    """
    known = _by_signal(guesses, numbers)
    moving = [known[name] for name in ("motor_position", "speed", "output_position") if name in known]
    if not moving or len(moving[0]) < _SERIES or _rested(known):
        return False
    if not all(np.median(np.abs(np.diff(values))) < NEGLIGIBLE * np.ptp(values) for values in moving):
        return False
    position = next((known[name] for name in ("motor_position", "output_position") if name in known), None)
    if position is None:
        return True
    steps = np.diff(position)
    if "speed" in known:
        return steady_factor(steps, known["speed"][1:]) is not None
    usual = float(np.median(np.abs(steps)))
    return usual == 0.0 or float(np.mean(np.abs(np.abs(steps) - usual) < PART * usual)) < NEARLY_ALL


def _by_signal(guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {guess.signal: numbers[guess.column] for guess in guesses.signals}


def _uneven(time: np.ndarray) -> bool:
    """Whether many steps of a time (n,) are far from the usual one, as no clock makes them that drops a few."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    if usual <= 0.0:
        return False
    return float(np.mean((steps > usual / _CLOCKED) & (steps < _CLOCKED * usual))) < MOSTLY


def _rested(known: Mapping[str, np.ndarray]) -> bool:
    """Whether the speed is zero at all rows but a few, between which the position goes on."""
    position = next((known[name] for name in ("motor_position", "output_position") if name in known), None)
    if position is None or "speed" not in known or np.ptp(position) == 0.0:
        return False
    return bool(np.mean(known["speed"] == 0.0) >= ALL_BUT_SPIKES)
