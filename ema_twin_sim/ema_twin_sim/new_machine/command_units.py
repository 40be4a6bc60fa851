"""Units of commands that their names do not tell: those of what follows them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS, header_words
from ema_bench_replay.units import units_of

from ..criteria import PART
from .column_quantity import has_word
from .column_words import ACTUAL, FILTERED, OUTPUT, SETPOINT, UNPROCESSED
from .columns import Guess
from .compared_ways import differences, is_open, radians, steady

_FOLLOWED_BY = {
    "speed_setpoint": ("speed",),
    "current_setpoint": ("current",),
    "output_command": ("output_position", "motor_position"),
}
"""By command, the signals that follow it; the first that is measured counts."""


def commands_with_units(signals: Mapping[str, Guess], numbers: Mapping[str, np.ndarray]) -> dict[str, Guess]:
    """The commands without a unit that have that of what follows them, by signal; ``numbers`` (n,) are by column."""
    found = {}
    for name in _FOLLOWED_BY:
        command, measured = signals.get(name), _follower(name, signals)
        if command is None or command.unit is not None or measured is None or measured.unit in (None, COUNTS):
            continue
        if _is_in_its_unit(command, measured, numbers):
            found[name] = replace(command, unit=measured.unit, factor=measured.factor, doubt=measured.doubt)
    return found


def why_no_command(signals: Mapping[str, Guess], numbers: Mapping[str, np.ndarray]) -> str:
    """Why a commanded position is not used; empty if it is the output's, judged by the measured one, or if none is."""
    command, followed = signals.get("output_command"), _follower("output_command", signals)
    if command is None:
        return ""
    unsaid = command.unit in (None, COUNTS)
    if followed is not None and unsaid and command.unit == followed.unit is None:
        unsaid = not _is_in_its_unit(command, followed, numbers)
    if unsaid:
        return "neither its name nor its numbers tell its unit"
    if followed is None or is_open(followed):
        return ""
    asked = numbers[command.column] * units_of("output_command")[command.unit or "rad"]
    times = steady(*differences(asked, numbers[followed.column] * radians(followed)))
    if times is None or abs(times - 1.0) < PART:
        return ""
    return f"it goes {abs(times):.3g} times as far as {followed.column}, and only a command of the output is read"


def _follower(command: str, signals: Mapping[str, Guess]) -> Guess | None:
    """The measured signal that follows a command; None if there is none."""
    return next((signals[name] for name in _FOLLOWED_BY[command] if name in signals), None)


def _is_in_its_unit(command: Guess, measured: Guess, numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether a command is followed one to one; where that is not steady, whether the names differ only in the side."""
    values = [numbers[command.column], numbers[measured.column]]
    scale = steady(*(differences(*values) if command.signal == "output_command" else values))
    return _family(command) == _family(measured) if scale is None else abs(scale - 1.0) < PART


def _family(guess: Guess) -> tuple[str, ...]:
    """The words of a column's name without those that tell a command from what is measured, or the output."""
    side = f"{SETPOINT}|{ACTUAL}|{FILTERED}|{UNPROCESSED}|{OUTPUT}"
    return tuple(word for word in header_words(guess.column).words if not has_word((word,), side))
