"""Rows at the ends of a trace that lack numbers of columns which are no signals: they belong to the recording."""

from __future__ import annotations

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.trace_table import TraceTable, read_table

from .columns import guess_columns


def with_rows_of_others(table: TraceTable, *, slides: bool) -> TraceTable:
    """A table, read without knowing its signals, with the rows that only columns beside these lack numbers in.

    It is read again with the time and the signals that its columns seem to be; if the machine ``slides`` is as in
    ``guess_columns``. A signal that lacks numbers in more rows than a recording's ends may holds NaN there.
    """
    numbers = table.numbers
    holed = frozenset(name for name, values in numbers.items() if np.isnan(values).any())
    try:
        guesses = guess_columns(table.header, holed, numbers, slides=slides)
    except InputError:  # what is wrong is told where the columns are guessed
        return table
    signals = {guess.column for guess in (guesses.time, *guesses.signals) if guess is not None}
    if not signals:
        return table
    return read_table(
        table.path,
        needed=lambda header: (),
        at_ends=lambda header: [header.index(name) for name in signals if name in header],
    )
