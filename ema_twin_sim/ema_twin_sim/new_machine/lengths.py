"""A slide's columns in units of length beside its motor's in units of turns: the way per turn makes lengths of all."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS, header_words
from ema_bench_replay.traces.wrapped_angle import counted_on
from ema_bench_replay.units import signal_unit, units_of

from .column_quantity import has_word
from .column_words import SETPOINT
from .columns import Guess, Guesses
from .travel_per_turn import HOW_TO_GIVE, in_mm


def how_to_use_length(name: str, guesses: Guesses) -> str:
    """That the way per turn is to be given for a column with a unit of the other motion; empty if that would not help.

    Empty too for all but the first such column, for a setpoint, and for a length if the output's position is known.
    """
    if name != guesses.other_motion[0]:
        return ""
    read = header_words(name)
    if has_word(read.words, SETPOINT):
        return ""
    if read.unit == COUNTS:
        return "if it counts the motor's turns, write them into the file as 'motor position [rev]'; "
    if guesses.motion == "linear":
        return f"if it is of the motor that moves the slide, give the way per turn, {HOW_TO_GIVE}; "
    if read.quantity != "position" or any(guess.signal == "output_position" for guess in guesses.signals):
        return ""
    return f"if the motor moves it by a screw, a belt or a rack, give the way per turn, {HOW_TO_GIVE}; "


def at_the_slide(guesses: Guesses, travel: float | None, numbers: Mapping[str, np.ndarray]) -> Guesses:
    """The guesses of a slide with its motor's turns and torques as ways and forces, by its ``travel`` [m] per turn.

    ``numbers`` are the columns' values, (n,) each. Without a ``travel``, or of a rotary machine, they stay as they are.
    """
    if travel is None or guesses.motion == "rotary":
        return guesses
    signals, torques = (
        tuple(_at_the_slide(guess, travel, numbers) for guess in each)
        for each in (guesses.signals, guesses.other_torques)
    )
    return replace(guesses, signals=signals, other_torques=torques)


def _at_the_slide(guess: Guess, travel: float, numbers: Mapping[str, np.ndarray]) -> Guess:
    """A column in a unit of turns, or of torque, in the slide's unit; others unchanged."""
    if not is_of_turns(guess.column):
        return guess
    unit, size = signal_unit(guess.signal, "linear"), units_of(guess.signal)[header_words(guess.column).unit or ""]
    per_radian = travel / (2.0 * math.pi)
    factor = size / per_radian if guess.signal.endswith("torque") else size * per_radian
    wraps = guess.signal.endswith("position") and counted_on(numbers[guess.column], 2.0 * math.pi / size)[1] > 0
    return replace(guess, unit=unit, factor=factor, wraps_after=travel if wraps else None)


def is_of_turns(column: str) -> bool:
    """Whether a column's unit is one of turns or of torques."""
    return header_words(column).linear is False


def told_of_turns(guesses: Guesses, travel: float | None) -> tuple[str, ...]:
    """Which columns were read by the way per turn, in words; empty if none was."""
    columns = [guess.column for guess in guesses.signals if is_of_turns(guess.column)]
    if travel is None or not columns:
        return ()
    return (f"{', '.join(columns)} as of the slide, {in_mm(travel)} per turn (`factor` in the map)",)
