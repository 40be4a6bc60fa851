"""Control errors, whatever their names: a command of a position or a speed minus what is measured of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import permutations

import numpy as np

from ema_bench_replay.traces.header_words import HeaderWords

from ..criteria import NEGLIGIBLE, SMALL
from .signal_columns import signal_column

_CONTROLLED = ("position", "speed")


def control_errors(names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> dict[str, str]:
    """What each column that is a control error is the difference of, in words, by its name.

    ``numbers`` (n,) are each column's. Of two columns that add up to the command the one that goes less far is the
    error.
    """
    columns = [column for column in map(signal_column, names) if column is not None and column.name in numbers]
    found = {}
    for command in (column for column in columns if column.setpoint and column.quantity in _CONTROLLED):
        alike = (command.quantity, command.read.unit)
        measured = [c for c in columns if not c.setpoint and (c.quantity, c.read.unit) == alike]
        for one, error in permutations(measured, 2):
            if _is_difference(numbers[error.name], numbers[command.name], numbers[one.name]):
                found[error.name] = f"{command.name} minus {one.name}"
    return found


def _is_difference(error: np.ndarray, command: np.ndarray, measured: np.ndarray) -> bool:
    """Whether values (n,) are the command minus the measured ones, or the reverse, and all three change.

    What follows the command is measured: behind a gear of ratio 2 it is the motor's position minus the command too.
    """
    known = np.isfinite(error) & np.isfinite(command) & np.isfinite(measured)
    values = [each[known] for each in (error, command, measured)]
    if not known.any() or min(float(np.ptp(each)) for each in values) == 0.0:
        return False
    error, command, measured = values
    follows = float(np.abs(command - error).max()) < SMALL * float(np.ptp(command))
    if follows or np.ptp(error) > np.ptp(measured):
        return False
    off = min(float(np.abs(command - measured - sign * error).max()) for sign in (1.0, -1.0))
    return off < NEGLIGIBLE * float(np.ptp(error))
