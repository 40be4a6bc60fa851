"""Header units: whether a column's own name tells another unit than the one in which the import map reads it."""

from __future__ import annotations

from ema_bench_replay.traces.header_words import header_words
from ema_bench_replay.units import ALL_UNITS, MOTIONS, units_of


def contradicted_unit(column: str, signal: str, unit: str | None) -> str | None:
    """The unit in a column's name if the map reads its signal in another ``unit``; None if nothing contradicts that.

    A unit that may be a subscript does not count. Without brackets around it, it counts only as a unit of the signal,
    since a word such as ``n`` may also be a symbol.
    """
    told = header_words(column)
    if unit not in ALL_UNITS or told.unit not in ALL_UNITS or told.unit == unit or told.in_doubt:
        return None
    in_brackets = column.rstrip().endswith(("]", ")"))
    return told.unit if in_brackets or any(told.unit in units_of(signal, motion) for motion in MOTIONS) else None
