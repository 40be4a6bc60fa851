"""Rows at either end of a table that lack numbers which all other rows hold.

A logger writes such rows when it is switched on before its drive answers, or off meanwhile.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import numpy as np

MOST = 3  # such rows; more are no end

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
