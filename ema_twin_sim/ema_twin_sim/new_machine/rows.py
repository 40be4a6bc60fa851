"""Decide what the rows of a table are: samples of one motion, or operating points (at rest or at constant speed)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.import_map import TIME_UNITS

from ..criteria import ALL_BUT_SPIKES, NEARLY_ALL, NEGLIGIBLE, PART
from ..measured.way_by_speed import steady_factor
from ..model.constants import CONSTANTS
from .clock import is_uneven
from .columns import Guesses

_SERIES = 500  # rows; fewer may be operating points, one after the other


def with_kind_of_rows(guesses: Guesses, numbers: Mapping[str, np.ndarray], said: bool) -> Guesses:
    """The guesses, with rows as operating points if the user ``said`` so, or if the ``numbers`` look like it.

    Points that are not in the order of their time lose the time column. Raises InputError if rows without a time look
    like samples.
    """
    if said:
        guesses = replace(guesses, of_points=True, points_doubt="")
    elif why := _why_points(guesses, numbers):
        guesses = replace(guesses, of_points=True, points_doubt=why)
    elif guesses.time is None and _is_time_series(guesses, numbers):
        raise InputError(
            "the rows look like samples; export the time too, in a column named 'time [s]' or 'time [ms]'; if each row "
            "is an operating point, at rest or at constant speed, give --operating-points"
        )
    if guesses.of_points and guesses.time is not None and not (np.diff(numbers[guesses.time.column]) > 0.0).all():
        guesses = replace(guesses, time=None, left=(*guesses.left, guesses.time.column))
    return guesses


def may_be_points(count: int) -> bool:
    """Whether so many rows whose time goes back may be operating points in any order."""
    return count < _SERIES


def _why_points(guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> str:
    """Why rows with a time are operating points nevertheless; empty if they are samples.

    ``numbers`` (n,) are each column's values. No clock sampled the rows, and either the shaft rested at each of them
    although it moved from one to the next, or they are too far apart in time to show a motion.
    """
    if guesses.time is None:
        return ""
    time = numbers[guesses.time.column]
    if not is_uneven(time):
        return ""
    known = _by_signal(guesses, numbers)
    if _rested(known):
        return "the rows are not evenly spaced in time, and the speed is zero in each"
    longest = CONSTANTS["sensors.sample_period"].upper
    unit = guesses.time.unit
    if unit is not None and float(np.median(np.diff(time))) * TIME_UNITS[unit] * 1e-9 > longest:
        return f"the rows are not evenly spaced in time, and are more than {longest:g} s apart"
    return ""


def _is_time_series(guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether rows without a time follow each other like samples, and are not operating points.

    Then positions and speeds change slowly from row to row, and the steps of the position fit the speed. If there is a
    position alone and it always moves by the same step, it was set (or turned steadily, which looks the same).
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
        between = 0.5 * (known["speed"][1:] + known["speed"][:-1])  # a speed may change much in one step
        return steady_factor(steps, between) is not None
    usual = float(np.median(np.abs(steps)))
    return usual == 0.0 or float(np.mean(np.abs(np.abs(steps) - usual) < PART * usual)) < NEARLY_ALL


def _by_signal(guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {guess.signal: numbers[guess.column] for guess in guesses.signals}


def _rested(known: Mapping[str, np.ndarray]) -> bool:
    """Whether the speed is zero at all but a few rows, although the position changes between them."""
    position = next((known[name] for name in ("motor_position", "output_position") if name in known), None)
    if position is None or "speed" not in known or np.ptp(position) == 0.0:
        return False
    return bool(np.mean(known["speed"] == 0.0) >= ALL_BUT_SPIKES)
