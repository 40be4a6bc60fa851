"""Exports in which each row holds the columns of one topic only: all are brought to one topic's times.

So PlotJuggler writes what it shows, and so do programs that merge the topics of a bag: the rows of the topics take
turns, and the cells of the others are empty.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ema_bench_replay.some_of import some_of

if TYPE_CHECKING:
    from ema_bench_replay.traces.trace_table import TraceTable

_FEWEST = 20  # rows of the topic that is kept: fewer are no recording
_SHARED = 0.1  # share of a topic's rows that may hold another's columns too, for example written at the same time
_LASTS = 0.5  # share of the kept rows during which another topic lasts: a shorter one does not shorten the recording
_RARE = 10.0  # usual steps between kept rows from which on the last value of another topic stands, as a command does


def with_topics_joined(table: TraceTable) -> TraceTable | None:
    """A table of merged topics with the rows of the one that holds the most numbers, where all others have values too.

    These are interpolated; where a column jumps, or its rows are rare, its last value stands. Rows before a topic
    begins or after it ends are left out. None if no topics are merged: then cells are empty only now and then.
    """
    filled = [np.isfinite(column) for column in table.columns]
    clock = next((k for k, rows in enumerate(filled) if rows.all() and _is_clock(table.columns[k])), None)
    topics = _topics(filled)
    if clock is None or not any(
        _take_turns(filled[one[0]], filled[other[0]]) for one, other in combinations(topics, 2)
    ):
        return None
    kept = max(topics, key=lambda topic: len(topic) * np.count_nonzero(filled[topic[0]]))
    base = np.flatnonzero(filled[kept[0]])
    if len(base) < _FEWEST:
        return None
    time = table.columns[clock]
    joined = {k: _at(time[base], time[filled[k]], table.columns[k][filled[k]]) for topic in topics for k in topic}
    whole = np.isfinite([each for each in joined.values() if np.isfinite(each).mean() >= _LASTS]).all(axis=0)
    columns = list(table.columns)
    for k, values in joined.items():
        columns[k] = np.full(len(time), np.nan)
        columns[k][base] = values
    most = max(table.decimals)  # the first rows do not tell those of a topic that begins later
    decimals = [most if k in joined else own for k, own in enumerate(table.decimals)]
    left_out = np.ones(len(time), dtype=bool)
    left_out[base[whole]] = False
    others = [topic for topic in topics if topic is not kept]
    warned = (*table.warnings, _in_words(table, kept, others, filled, int(whole.sum())))
    return replace(table, columns=columns, decimals=decimals, warnings=warned).without(np.flatnonzero(left_out))


def _is_clock(column: np.ndarray) -> bool:
    """Whether a column (n,) never falls and rises at all."""
    return len(column) > 1 and bool((np.diff(column) >= 0.0).all()) and bool(column[-1] > column[0])


def _topics(filled: list[np.ndarray]) -> list[list[int]]:
    """The columns of each topic: those that hold numbers in the same rows, but not in all."""
    found: dict[bytes, list[int]] = {}
    for k, rows in enumerate(filled):
        if rows.any() and not rows.all():
            found.setdefault(np.packbits(rows).tobytes(), []).append(k)
    return list(found.values())


def _take_turns(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether rows that hold one topic (n,) and rows that hold another alternate while both last."""
    if np.count_nonzero(one & other) > _SHARED * min(np.count_nonzero(one), np.count_nonzero(other)):
        return False
    (first, last), (begin, end) = (np.flatnonzero(rows)[[0, -1]] for rows in (one, other))
    if max(first, begin) > min(last, end):
        return False
    both = slice(max(first, begin, 1) - 1, min(last, end) + 2)
    fewer = min(np.count_nonzero(one[both]), np.count_nonzero(other[both]))
    whose = one[both][(one | other)[both]]
    return bool(fewer <= np.count_nonzero(np.diff(whose)))


def _at(time: np.ndarray, own_time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A topic's values (k,) at other times (n,), interpolated; NaN before it begins and after it ends.

    The last value stands where the next one comes much later than other times do, or is more than half of the range
    away, as at the end of a turn. A topic that is rare throughout does not end. Whole numbers stay whole.
    """
    rare = _RARE * float(np.median(np.diff(time)))
    ends = own_time[-1] if len(values) > 1 and np.median(np.diff(own_time)) <= rare else np.inf
    later = np.searchsorted(own_time, time, side="right")
    before, after = np.maximum(later - 1, 0), np.minimum(later, len(values) - 1)
    steps, rises = own_time[after] - own_time[before], values[after] - values[before]
    stands = (steps > rare) | (np.abs(rises) > 0.5 * np.ptp(values)) | (steps == 0.0)
    shares = np.where(stands, 0.0, (time - own_time[before]) / np.where(stands, 1.0, steps))
    found = values[before] + shares * rises
    if (values == np.rint(values)).all():
        found = np.rint(found)
    return np.where((later == 0) | (time > ends), np.nan, found)


def _in_words(table: TraceTable, kept: list[int], others: list[list[int]], filled: list[np.ndarray], count: int) -> str:
    """What was joined, and how: the topics' rows and columns, and how many rows are left."""

    def told(topic: list[int]) -> str:
        return f"{np.count_nonzero(filled[topic[0]])} rows of {some_of(table.header[k] for k in topic)}"

    of_others = " and of the ".join(map(told, others))
    return (
        f"{table.path.name}: each row holds the columns of one topic only, so they are joined: to the times of the "
        f"{told(kept)} the values of the {of_others} are interpolated, or stand where they are rare; {count} rows are "
        "used"
    )
