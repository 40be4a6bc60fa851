"""Check whether the map drafted from a machine's first trace also reads its other traces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.some_of import some_of
from ema_bench_replay.traces.trace_table import read_table

from .columns import Guesses, guess_columns
from .interleaved_rows import refuse_interleaved_rows


def differing_columns(first: Path, guesses: Guesses, others: Sequence[Path], *, slides: bool) -> Iterator[str]:
    """Yield a sentence for what a map of the ``first`` trace's columns does not read, or misses, in the ``others``.

    Whether the machine ``slides`` by a known way per turn of its motor decides which columns are used.
    Raises InputError if another trace has the same signals under other names, so that the map would not find them, if
    it has no time or none of the signals, or if its rows are those of several parts that take turns.
    """
    wanted = {guess.signal: guess.column for guess in guesses.signals}
    if guesses.time is not None:
        wanted["time"] = guesses.time.column
    for other in others:
        table = read_table(other, needed=lambda header: ())
        missing = {signal: column for signal, column in wanted.items() if column not in table.header}
        numbers = table.numbers
        empty = frozenset(name for name, column in numbers.items() if np.isnan(column).all())
        theirs = guess_columns(table.header, empty, numbers, guesses.joint.name, slides=slides)
        named = {guess.signal: guess.column for guess in theirs.signals}
        if theirs.time is not None:
            named["time"] = theirs.time.column
        if renamed := [f"{named[signal]!r} for {column!r}" for signal, column in missing.items() if signal in named]:
            raise InputError(
                f"{other}: has other column names than {first}: {some_of(renamed)}; give both the same names, "
                "or run init for each kind of file apart and make recordings of each by its map (ema-twin import --map)"
            )
        refuse_interleaved_rows(table, replace(theirs, of_points=guesses.of_points), numbers)
        if "time" in missing or {*wanted} - {"time"} <= {*missing}:
            lacked = "time column" if "time" in missing else f"column {some_of(map(repr, wanted.values()))}"
            raise InputError(
                f"{other}: lacks the {lacked} of {first}, so one map cannot read both; run init for each kind of file"
            )
        if missing:
            yield f"{other}: lacks the column {some_of(map(repr, missing.values()))} of {first}: read without it"
        known = {*wanted.values(), *guesses.left}
        if more := [column for signal, column in named.items() if signal not in wanted and column not in known]:
            yield (
                f"{other}: its {some_of(map(repr, more))} is not in {first}, from which the map is made, so it is "
                f"not used; list {other} first to use it"
            )
