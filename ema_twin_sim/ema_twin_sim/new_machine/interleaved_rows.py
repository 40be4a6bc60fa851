"""Traces in which the rows of several motors or joints take turns, as a bus delivers them: no rows of one motion.

A column tells the parts apart, by a number or a name. Read as one, the motion would jump from part to part.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.some_of import some_of
from ema_bench_replay.traces.column_texts import column_texts
from ema_bench_replay.traces.trace_table import TraceTable

from ..criteria import MOSTLY, PART
from ..measured.way_by_speed import FEWEST
from .columns import Guesses

_MOST_PARTS = 64
_LOOKED_AT = 2000  # rows
_MOVES = ("motor_position", "output_position", "speed")


def refuse_interleaved_rows(table: TraceTable, guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> None:
    """Raise InputError if a column tells several parts apart whose rows take turns; ``numbers`` (n,) are by name."""
    if guesses.of_points or guesses.time is None:
        return
    time = numbers[guesses.time.column][:_LOOKED_AT]
    used = {guess.column for guess in guesses.signals} | {guesses.time.column}
    ways = [numbers[guess.column][:_LOOKED_AT] for guess in guesses.signals if guess.signal in _MOVES]
    for name, parts, told in _keys(table, numbers, used):
        smoothest = min((_apart_over_all(way, parts) for way in ways), default=1.0)
        if smoothest < PART or (smoothest < 1.0 and _at_the_same_times(time, parts)):
            raise InputError(
                f"{table.path}: column {name!r} tells {len(told)} parts apart ({some_of(told)}), and their rows take "
                f"turns: write the rows of each into a file of its own, as those with {name} {told[0]}, and run init "
                "with one of them"
            )


def _keys(
    table: TraceTable, numbers: Mapping[str, np.ndarray], used: set[str]
) -> Iterator[tuple[str, np.ndarray, list[str]]]:
    """Columns that may tell parts apart: name, the number of each row's part (n,), and what the parts are called."""
    for place, name in enumerate(table.header):
        values = numbers[name][:_LOOKED_AT]
        if name in used or len(values) < FEWEST:
            continue
        if np.isnan(values).all():
            cells = np.array(column_texts(table, place, len(values)))
            if len(cells) != len(values):
                continue
            told, parts = np.unique(cells, return_inverse=True)
            names = [str(cell) for cell in told]
        elif np.isfinite(values).all() and np.array_equal(values, np.rint(values)):
            whole, parts = np.unique(values, return_inverse=True)
            names = [f"{value:.0f}" for value in whole]
        else:
            continue
        if 1 < len(names) <= _MOST_PARTS and all(names) and _take_turns(parts, len(names)):
            yield name, parts, names


def _take_turns(parts: np.ndarray, count: int) -> bool:
    """Whether each part mostly comes again after all ``count`` parts, as no comment or state of one machine does."""
    later = np.concatenate([np.diff(np.flatnonzero(parts == part)) for part in range(count)])
    return float(np.sum(later == count)) > MOSTLY * len(parts)


def _at_the_same_times(time: np.ndarray, parts: np.ndarray) -> bool:
    """Whether most rows tell a time (n,) that others tell too, each of another part (n,)."""
    times, rows = np.unique(time, return_counts=True)
    shared = float(np.sum(rows[rows > 1])) > MOSTLY * len(time)
    return shared and len(np.unique(np.stack([time, parts]), axis=1).T) == len(time) > len(times)


def _apart_over_all(way: np.ndarray, parts: np.ndarray) -> float:
    """How far a motion (n,) goes from row to row of each part, over how far from row to row of all; 1 if unknown."""
    steps = np.abs(np.diff(way))
    apart = np.concatenate([np.abs(np.diff(way[parts == part])) for part in np.unique(parts)])
    apart, steps = apart[np.isfinite(apart)], steps[np.isfinite(steps)]
    if min(len(apart), len(steps)) < FEWEST or not np.mean(steps) > 0.0:
        return 1.0
    return float(np.mean(apart) / np.mean(steps))
