"""Columns that have one name: a map finds a column by its name, so it would read the first, whichever is meant."""

from __future__ import annotations

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.trace_table import TraceTable

from ..listing import listed
from .columns import Guesses


def refuse_same_names(table: TraceTable, guesses: Guesses) -> None:
    """Raise InputError if a signal's column, or the time's, has the name of another one with other values."""
    for guess in (*((guesses.time,) if guesses.time is not None else ()), *guesses.signals):
        first, *others = (place for place, name in enumerate(table.header) if name == guess.column)
        if all(np.array_equal(table.columns[first], table.columns[other], equal_nan=True) for other in others):
            continue
        places = listed(str(place + 1) for place in (first, *others))
        raise InputError(
            f"{table.path}: line {table.header_line}: columns {places} are all named {guess.column!r}, and hold "
            f"different values; give each a name of its own, as in 'motor position [rad]', and run init again"
        )
