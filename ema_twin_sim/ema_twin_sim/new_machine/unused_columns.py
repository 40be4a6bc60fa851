"""Why columns are not used though they may be meant: their unit is none of any signal, or another column was taken."""

from __future__ import annotations

import re
from collections.abc import Collection

from ema_bench_replay.traces.header_words import header_words

from .column_words import ACCELERATION_UNIT, POWER_UNIT
from .columns import Guesses
from .signal_columns import signal_column


def with_unknown_units(columns: Collection[str]) -> list[str]:
    """Those of the columns whose unit is known of no quantity; powers and accelerations are known to be no signals."""
    told = {name: header_words(name).foreign for name in columns}
    return [name for name, unit in told.items() if unit and not unit.isdigit() and not _of_no_signal(unit)]


def beside_those_taken(guesses: Guesses, columns: Collection[str]) -> list[str]:
    """Those of the columns that measure what another column was taken for; none if these are several joints'."""
    if guesses.joint.name:
        return []
    told = {*guesses.other_motion, *guesses.other_axes, *guesses.row_counters, *guesses.clock_counters}
    told |= {*guesses.electrical, *guesses.control_errors, *(guess.column for guess in guesses.other_torques)}
    taken = {header_words(guess.column).quantity or _quantity(guess.column) for guess in guesses.signals}
    return [name for name in columns if name not in told and _quantity(name) in taken]


def _of_no_signal(unit: str) -> bool:
    return re.fullmatch(f"{POWER_UNIT}|{ACCELERATION_UNIT}", unit) is not None


def _quantity(name: str) -> str:
    """What a column measures; empty if it measures no signal, or commands one."""
    read = header_words(name)
    column = signal_column(read)
    return "" if column is None or column.setpoint else column.quantity
