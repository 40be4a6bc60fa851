"""Positions that only a symbol or a unit tells: what is to be checked where much rests on them."""

from __future__ import annotations

from ema_bench_replay.traces.header_words import header_words

from .column_quantity import has_word
from .column_words import MOTOR, MOVED, OUTPUT, STEMS
from .columns import Guess, Guesses

_TELLING = f"{STEMS['position']}|{MOTOR}|{OUTPUT}|{MOVED}"
HOW_TO_NAME = "if one is not, remove it; else say so in its name, as in 'motor position'; and run init again"


def unnamed_pair(guesses: Guesses) -> tuple[Guess, Guess] | None:
    """The positions of motor and output if no word of either tells one; None otherwise. A number is no such word."""
    motor, output = (guesses.by_signal.get(name) for name in ("motor_position", "output_position"))
    if motor is None or output is None or _is_named(motor) or _is_named(output):
        return None
    return motor, output


def unnamed_beside_speed(guesses: Guesses) -> Guess | None:
    """The motor's position in a table of operating points with a speed if no word tells one; None otherwise.

    There nothing shows that it is one: the points are apart, and the speed does not lead from one to the next.
    """
    found = guesses.by_signal
    position = found.get("motor_position")
    if not guesses.of_points or position is None or "speed" not in found or _is_named(position):
        return None
    return position


def _is_named(guess: Guess) -> bool:
    """Whether a word of a column's name tells a position or a side."""
    return has_word([word for word in header_words(guess.column).words if not word.isdigit()], _TELLING)
