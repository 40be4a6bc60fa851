"""Guess to which shaft a motor's position belongs: from how far it goes if the motor's speed is known, otherwise from
whether a motor behind its gear would turn so little.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import ALL_BUT_SPIKES, CLEARLY_MORE, FAR_OUT, NEARLY_ALL, PART, SMALL
from ..measured.robust_regression import bulk_regression
from ..measured.signal_factors import is_usual_mistake
from ..measured.smoothing import gaussian, smooth
from ..measured.usual_sizes import USUAL
from ..measured.way_by_speed import travelled_by_speed, way_by_speed
from ..model.constants import CONSTANTS
from ..reading_noise import reading_noise

OWN = 0.1  # relative deviation up to which a position moves as the motor's speed says
ALIKE = 0.02  # deviation from a gear ratio of one up to which both shafts turn alike
SAME_RATIO = 0.1  # relative deviation up to which a ratio agrees with the given gear ratio
NEAR_A_WHOLE = 0.05  # of a turn
ANGLE_ERROR = 1e-3  # rad, of an encoder over the travel of a recording
EXACT = 2e-4  # relative deviation up to which a ratio is the whole number beyond doubt
GEARED = 5.0
"""Gear ratio from which the purpose of a gear is to let the motor run fast. Lower ratios are belts and couplings, whose
shafts turn about equally fast, so that their speeds do not show which is which."""
_FEWEST_TO_REFINE = 400  # samples
_SMOOTHED = 10.0  # samples
_AT_ENDS = 40  # samples at either end that this smoothing distorts by more than half a per cent
_ROUND = 1.0 / 3.0  # of a turn of the output, beyond which an angle error can be distinguished from a slope
_MOVING = 0.3  # of the largest distance
_FEWEST = 10
_PIECES = 500  # of a recording, over each of which a speed is computed
_WINDOWS = (0.1, 0.061)  # of a recording's samples, over which the motions of the shafts are compared


@dataclass(frozen=True)
class Shaft:
    """Whose turns a motor's position counts (``motor`` or ``output``), the gear ratio that shows, and what to check.

    ``ratio`` is None if the recording shows none. An empty ``doubt`` means that there is none. ``doubt_of_ratio`` is of
    one that both positions show.
    """

    name: str = "motor"
    ratio: float | None = None
    doubt: str = ""
    doubt_of_ratio: str = ""


def position_shaft(recording: Recording, gear_ratio: float | None, *, units_known: bool) -> Shaft:
    """The shaft of a recording's motor position, read as the motor's; ``gear_ratio`` is the one given, if any."""
    if recording.motion != "rotary" or recording.of_points:
        return Shaft(doubt=_of_a_carriage(recording) if units_known and not recording.of_points else "")
    between = ratio_of_positions(recording)
    alike = between is not None and abs(between - 1.0) < ALIKE
    times = way_by_speed(recording) if units_known else None
    if times is None:
        if alike and gear_ratio is not None and abs(gear_ratio - 1.0) > OWN:
            return Shaft("output", gear_ratio, "it turns like the output: assumed to be the output's angle")
        return Shaft()
    if abs(abs(times) - 1.0) < OWN:
        return Shaft()
    told = _told(times)
    ratio = 1.0 / abs(times)
    if gear_ratio is not None and abs(ratio / gear_ratio - 1.0) > SAME_RATIO:
        return Shaft(doubt=f"{told}; expected 1 or 1 / gear ratio. Are the units right?")
    strange = ratio < 1.0 or not is_possible(ratio) or is_usual_mistake(times)
    if gear_ratio is None and not alike and strange:
        return Shaft(doubt=f"{told}. Are the units of both right?")
    told += ": assumed to be the output's angle"
    if gear_ratio is None:
        told += " (without a gear a unit, or the time, is wrong by that factor)"
    return Shaft("output", gear_ratio or ratio, told)


def _told(times: float) -> str:
    return f"the position changes {abs(times):.4g} times as much as the integral of the speed"


def _of_a_carriage(recording: Recording) -> str:
    """What to check of a carriage's position beside its speed, between which there is no gear."""
    times = way_by_speed(recording)
    return "" if times is None or abs(abs(times) - 1.0) < OWN else f"{_told(times)}. Are the units of both right?"


def shaft_by_travel(recordings: Sequence[Recording], gear_ratio: float | None, *, of_a_robot: bool) -> Shaft:
    """The shaft of a motion whose name gives none, behind a gear, by how far it goes in turns; with what to check.

    A motor that stays within one turn would move the output by next to nothing, and one that moves it by a considerable
    part of a turn is the motor. Between these a robot that tells several joints tells angles of its outputs.
    """
    if not is_geared(gear_ratio) or any(r.motion != "rotary" or r.of_points for r in recordings):
        return Shaft()
    turns = max(map(_travel, recordings)) / (2.0 * math.pi)
    fastest = max(map(fastest_motion, recordings))
    if not turns > 0.0 or turns >= PART * gear_ratio or fastest * gear_ratio > USUAL["speed"][1]:
        return Shaft()
    by = f"{360.0 * turns / gear_ratio:.3g} deg"
    told = f"it goes {turns:.3g} turns in all, which as the motor's would turn the output by {by}"
    if turns <= 1.0 or of_a_robot:
        return Shaft("output", gear_ratio, told)
    return Shaft(doubt=f"{told}: is it the motor's?")


def _travel(recording: Recording) -> float:
    """From end to end of the motor's position [rad], or else of the way by its speed; 0 if there is neither."""
    if recording.has("motor_position"):
        way = recording.signals["motor_position"]
    elif recording.has("speed"):
        way = travelled_by_speed(recording)
    else:
        return 0.0
    way = way[np.isfinite(way)]
    return float(np.ptp(way)) if len(way) else 0.0


def is_geared(gear_ratio: float | None) -> TypeGuard[float]:
    """Whether a gear ratio is given that lets the motor run fast: its shafts cannot be taken for each other."""
    return gear_ratio is not None and gear_ratio >= GEARED


def fastest_motion(recording: Recording) -> float:
    """Highest speed [rad/s] by the motor's speed, else by its position, without a few peaks; 0 if there is neither."""
    if recording.has("speed"):
        speed = recording.signals["speed"]
    elif recording.has("motor_position") and len(recording) > _FEWEST:
        every = max(1, len(recording) // _PIECES)
        speed = np.diff(recording.signals["motor_position"][::every]) / np.diff(recording.time[::every])
    else:
        return 0.0
    speed = np.abs(speed[np.isfinite(speed)])
    return float(np.quantile(speed, ALL_BUT_SPIKES)) if len(speed) else 0.0


def is_possible(ratio: float) -> bool:
    """Whether a gear ratio, of either sign, is one that a model may have."""
    bounds = CONSTANTS["machine.gear_ratio"]
    return bounds.lower <= abs(ratio) <= bounds.upper


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
    speeds: at rest, and while play is crossed, it may be anywhere. The ``ratio`` of their ways if that tells no other.
    """
    motor, output = (recording.signals[name] for name in ("motor_position", "output_position"))
    step, bend = (smooth(motor, gaussian(_SMOOTHED, 1.0, order)) for order in (1, 2))
    follows = smooth(output, gaussian(_SMOOTHED, 1.0, 1))
    fast = (np.abs(step) > _MOVING * np.nanmax(np.abs(step))) & (np.abs(ratio * follows) > SMALL * np.abs(step))
    of_speeds = float(np.median(step[fast] / follows[fast])) if fast.sum() >= _FEWEST_TO_REFINE else ratio
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
    found = bulk_regression(columns[whole], motor[whole])
    return float(found[0]) if abs(found[0] / of_speeds - 1.0) < ALIKE else ratio


def positions_part(recording: Recording, ratio: float) -> bool:
    """Whether motor and output encoder differ by far more than their noise: then play or compliance is between them."""
    motor, output = (recording.signals[name] for name in ("motor_position", "output_position"))
    known = np.isfinite(motor) & np.isfinite(output)
    noise = math.hypot(reading_noise(motor[known]), ratio * reading_noise(output[known]))
    return _parting(recording, ratio) > FAR_OUT * noise


def _parting(recording: Recording, ratio: float) -> float:
    """Range [rad of the motor] of the difference between both positions, without a few samples."""
    apart = recording.signals["motor_position"] - ratio * recording.signals["output_position"]
    return float(np.ptp(np.quantile(apart[np.isfinite(apart)], (1.0 - NEARLY_ALL, NEARLY_ALL))))


def whole_ratio(ratio: float, recording: Recording) -> float | None:
    """The whole number from which an encoder's angle error, or play, may have shifted a ratio; None if none is so near.

    It is taken if the difference between the positions is about as small with it as with the slope.
    """
    nearest = float(round(ratio))
    if nearest == 0.0 or abs(ratio - nearest) > NEAR_A_WHOLE:
        return None
    travel = float(np.ptp(recording.signals["output_position"][np.isfinite(recording.signals["output_position"])]))
    if abs(ratio / nearest - 1.0) * travel < ANGLE_ERROR:
        return nearest
    return nearest if _parting(recording, nearest) < CLEARLY_MORE * _parting(recording, ratio) else None
