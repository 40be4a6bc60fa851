"""Rows at either end of a table that lack numbers which all other rows hold.

A logger writes such rows when it is switched on before its drive answers, or off meanwhile.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from ema_bench_replay.traces.missing_numbers import is_missing

MOST = 3  # such rows, if some hold what is no number; more are no end
MOST_EMPTY = 0.25  # share of the rows in which a column may be empty at an end; one of fewer values is no signal

Cells = Mapping[int, Mapping[int, str]]
"""Cells that are no numbers, by row and column."""


def incomplete_rows(
    ends: Iterable[tuple[range, np.ndarray]], cells: Cells, judged: Collection[int]
) -> tuple[range, int] | None:
    """The first of the ``ends`` in which every row lacks a number, with a column of its first row; None if none is one.

    Each comes with a mask (c,) of the columns that hold numbers in all other rows. Only the ``judged`` columns count.
    """
    for rows, held in ends:
        lacked = [next((at for at in cells.get(row, {}) if at in judged and held[at]), None) for row in rows]
        if lacked and (column := lacked[0]) is not None and None not in lacked:
            return rows, column
    return None


def empty_ends(rows: Sequence[Sequence[str]], count: int) -> tuple[dict[int, int], dict[int, int]]:
    """By column, the first rows in which its cells are empty, and the last, if there are more than MOST of them.

    ``rows`` are the cells of each row of a block; ``count`` are the rows so far, of which they may be up to MOST_EMPTY.
    Programs that write signals of their own lengths beside each other fill the shorter ones up with empty cells.
    """
    return _empty_first(rows, count), _empty_first(rows[::-1], count)


def _empty_first(rows: Sequence[Sequence[str]], count: int) -> dict[int, int]:
    """By column, in how many of the ``rows`` its cells are empty, counted from the first of them."""
    found = {}
    open_columns = [column for column, cell in enumerate(rows[0]) if _is_empty(cell)] if rows else []
    for number, cells in enumerate(rows):
        still = [column for column in open_columns if column < len(cells) and _is_empty(cells[column])]
        if MOST < number <= MOST_EMPTY * count:
            found.update(dict.fromkeys(set(open_columns).difference(still), number))
        open_columns = still
        if not still or number > MOST_EMPTY * count:
            break
    return found


def _is_empty(cell: str) -> bool:
    return not cell or is_missing(cell)


def left_out_words(line: int, count: int, column: str, cell: str, *, at_begin: bool) -> str:
    """What to say of ``count`` rows at an end, of which the first, in this line, holds such a cell."""
    which, others = ("first", "after them") if at_begin else ("last", "before")
    holds = f"holds {cell!r}, which is no number" if cell else "is empty"
    if count == 1:
        return f"line {line}: the {which} row is left out, since its column {column!r} {holds}"
    return (
        f"lines {line} to {line + count - 1}: the {which} {count} rows are left out, since they lack numbers that all "
        f"rows {others} hold; in the first of them, column {column!r} {holds}"
    )
