"""Exports in which each signal is a pair of columns, its time and its values, with its name in the line above.

So maxon's EPOS Studio and programs that save the curves of a plot write: ``Position,,Speed,`` above ``X,Y,X,Y``.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import places_where

if TYPE_CHECKING:
    from ema_bench_replay.traces.trace_table import TraceTable

_FEWEST = 2  # pairs: over a single one, a name may as well be information
_UNIT = r"\s*((?:\[[^\]]*\]|\([^)]*\))?)"
_TIME = re.compile(r"(x|t|time|zeit|timestamp)" + _UNIT, re.IGNORECASE)
_VALUE = re.compile(r"(?:y|values?|wert|data)" + _UNIT, re.IGNORECASE)


def names_of_pairs(above: str, line: str, mark: str) -> str | None:
    """A line of names, the time's before each signal's; None if a ``line`` does not name pairs of columns.

    ``above`` is the line above it, and ``mark`` stands between the cells. A unit beside a column's letter stays with
    its name; one of the times suffices.
    """
    over, cells = ([cell.strip(' "') for cell in text.split(mark)] for text in (above, line.removesuffix(mark)))
    count = len(cells)
    over += [""] * count
    if count % 2 or count < 2 * _FEWEST or any(over[count:]):
        return None
    names: list[str] = []
    clocks: set[str] = set()
    units: set[str] = set()
    for k in range(0, count, 2):
        time, value = _TIME.fullmatch(cells[k]), _VALUE.fullmatch(cells[k + 1])
        told = {*over[k : k + 2]} - {""}
        if time is None or value is None or len(told) != 1:
            return None
        name = told.pop()
        names.append(name if name.endswith(("]", ")")) else f"{name} {value[1]}".rstrip())
        clocks.add("time" if time[1].lower() == "x" else time[1])
        units.add(time[2])
    units -= {""}
    if len(clocks) > 1 or len(units) > 1:
        return None
    clock = " ".join((*clocks, *units))
    return mark.join(f"{clock}{mark}{name}" for name in names) + (mark if line.endswith(mark) else "")


def with_common_time(table: TraceTable) -> TraceTable:
    """A table of pairs with one column for the time. Raises InputError if the signals have times of their own."""
    time = table.columns[0]
    for k in range(2, len(table.columns), 2):
        other = table.columns[k]
        if (apart := places_where(lambda a, b: (a != b) & ~(np.isnan(a) & np.isnan(b)), time, other)).size:
            row = int(apart[0])
            told = " and ".join(f"{column[row]:.10g}" for column in (time, other)).replace("nan", "none")
            raise InputError(
                f"{table.place(row)}: each signal has a time of its own ({told} here, of {table.header[1]!r} and of "
                f"{table.header[k + 1]!r}); record all of them at the same times, or interpolate them to one column "
                "of time"
            )
    kept = [0, *range(1, len(table.columns), 2)]
    header, columns, decimals = ([of[k] for k in kept] for of in (table.header, table.columns, table.decimals))
    return replace(table, header=header, columns=columns, decimals=decimals)
