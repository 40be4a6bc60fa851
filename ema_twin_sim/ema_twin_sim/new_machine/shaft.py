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

from ..criteria import ALL_BUT_SPIKES, CLEARLY_MORE, FAR_OUT, NEARLY_ALL, PART
from ..measured.ratio_of_positions import ALIKE, ratio_of_positions
from ..measured.signal_factors import is_usual_mistake
from ..measured.usual_sizes import USUAL
from ..measured.way_by_speed import travelled_by_speed, way_by_speed
from ..model.constants import CONSTANTS
from ..reading_noise import reading_noise

OWN = 0.1  # relative deviation up to which a position moves as the motor's speed says
SAME_RATIO = 0.1  # relative deviation up to which a ratio agrees with the given gear ratio
NEAR_A_WHOLE = 0.05  # of a turn
ANGLE_ERROR = 1e-3  # rad, of an encoder over the travel of a recording
EXACT = 2e-4  # relative deviation up to which a ratio is the whole number beyond doubt
GEARED = 5.0
"""Gear ratio from which the purpose of a gear is to let the motor run fast. Lower ratios are belts and couplings, whose
shafts turn about equally fast, so that their speeds do not show which is which."""
_FEWEST = 10
_PIECES = 500  # of a recording, over each of which a speed is computed


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


def whole_ratio(ratio: float, recording: Recording, uncertainty: float = math.nan) -> float | None:
    """The whole number from which an encoder's angle error, or play, may have shifted a ratio; None if none is so near.

    It is taken if it is within the ``uncertainty`` and no other is, or if the difference between the positions is about
    as small with it as with the slope.
    """
    nearest = float(round(ratio))
    if nearest == 0.0:
        return None
    if abs(ratio - nearest) <= uncertainty <= PART:
        return nearest
    if abs(ratio - nearest) > NEAR_A_WHOLE:
        return None
    travel = float(np.ptp(recording.signals["output_position"][np.isfinite(recording.signals["output_position"])]))
    if abs(ratio / nearest - 1.0) * travel < ANGLE_ERROR:
        return nearest
    return nearest if _parting(recording, nearest) < CLEARLY_MORE * _parting(recording, ratio) else None
