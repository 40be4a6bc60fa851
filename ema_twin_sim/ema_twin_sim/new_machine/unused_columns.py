"""Why columns are not used though they may be meant: their unit is none of any signal, or another column was taken."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

import numpy as np

from ema_bench_replay.traces.header_words import header_words

from ..criteria import NEARLY_ALL
from .column_quantity import has_word, word_quantity
from .column_words import ACCELERATION_UNIT, DUTY, DUTY_SETTING, NO_SIGNAL, POWER_UNIT, SETPOINT
from .columns import Guesses
from .joints import likeness
from .never_changing import never_changes
from .row_counters import numbers_the_rows
from .signal_columns import signal_column
from .voltages import voltages


def with_unknown_units(columns: Collection[str]) -> list[str]:
    """Those of the columns whose unit is known of no quantity; powers and accelerations are known to be no signals."""
    told = {name: header_words(name).foreign for name in columns}
    of_no_signal = f"{POWER_UNIT}|{ACCELERATION_UNIT}"
    return [name for name, u in told.items() if u and not u.isdigit() and not re.fullmatch(of_no_signal, u)]


def beside_those_taken(guesses: Guesses, columns: Collection[str]) -> list[str]:
    """Those of the columns that measure or command what another column was taken for.

    Of several joints, those whose names have the words of the joint that was taken; none if it has only a number.
    """
    if guesses.joint.name.isdigit():
        return []
    columns = [name for name in columns if _apart(guesses.joint.name) in _apart(name)]
    told = {*guesses.other_motion, *guesses.other_axes, *guesses.row_counters, *guesses.clock_counters}
    told |= {*guesses.electrical, *guesses.control_errors, *guesses.repeats, *guesses.lost_commands}
    told |= {guess.column for guess in guesses.other_torques}
    taken = {header_words(guess.column).quantity or _quantity(guess.column) for guess in guesses.signals}
    return [name for name in columns if name not in told and _quantity(name) in taken]


def that_may_be_motion(guesses: Guesses, columns: Collection[str], numbers: Mapping[str, np.ndarray]) -> list[str]:
    """Those of the columns whose names tell nothing and whose numbers (n,) change; none beside a position or speed."""
    if any(guess.signal in ("motor_position", "speed") for guess in guesses.signals):
        return []
    return [name for name in columns if _is_unclear(name, guesses, numbers)]


def that_may_be_the_drives(guesses: Guesses, columns: Collection[str], numbers: Mapping[str, np.ndarray]) -> list[str]:
    """Those of the columns whose names tell nothing and whose numbers (n,) change, if a current or torque is missing.

    None if both encoders do without, or if a voltage or a duty cycle may stand for the torque.
    """
    signals = {guess.signal for guess in guesses.signals}
    if signals & {"current", "motor_torque"} or guesses.both_encoders or voltages(guesses):
        return []
    commands = that_may_be_commands(guesses, columns, numbers)
    return [name for name in columns if name not in commands and _is_unclear(name, guesses, numbers)]


def that_may_be_commands(guesses: Guesses, columns: Collection[str], numbers: Mapping[str, np.ndarray]) -> list[str]:
    """Those of the columns that command something that their names do not tell, or that move as a position does.

    ``numbers`` (n,) are each column's. Of several joints, those whose names have the words of the joint that was taken.
    """
    moving = [
        numbers[guess.column] for guess in guesses.signals if guess.signal in ("motor_position", "output_position")
    ]

    def is_like_one(name: str) -> bool:
        """Whether a column commands something by its name, or goes as a position does."""
        commands = has_word(header_words(name).words, SETPOINT)
        return commands or any(likeness(numbers[name], way) >= NEARLY_ALL for way in moving)

    of_joint = [name for name in columns if _apart(guesses.joint.name) in _apart(name)]
    return [name for name in of_joint if _is_unclear(name, guesses, numbers) and is_like_one(name)]


def _is_unclear(name: str, guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> bool:
    """Whether a column changes, its name tells nothing, and nothing else was said of it."""
    told = {*guesses.row_counters, *guesses.clock_counters, *guesses.sign_bits}
    if name in told or not _tells_nothing(name):
        return False
    return not (never_changes(numbers[name]) or numbers_the_rows(numbers[name]))


def _tells_nothing(name: str) -> bool:
    """Whether a column's name has neither a unit nor a word of any quantity, state or setting."""
    read = header_words(name)
    known = has_word(read.words, f"{NO_SIGNAL}|{DUTY}|{DUTY_SETTING}")
    return read.unit is None and not read.foreign and word_quantity(read.words) is None and not known


def _apart(name: str) -> str:
    """A name with single blanks between its words and at both ends; one blank if it is empty."""
    return " ".join(["", *re.findall(r"[^\W_]+", name), ""]) or " "


def _quantity(name: str) -> str:
    """What a column measures or commands; empty if that is no signal."""
    column = signal_column(header_words(name))
    return "" if column is None else column.quantity
