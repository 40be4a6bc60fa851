"""Bars that lie, one below another, each with its name before it and its number behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr

from .palette import GRID, TEXT, Colour
from .sheet import HIGH, LEFT, RIGHT, TOP, Axis, Sheet

_HALF = 1.6  # units
_ROW = 12.5
_LETTER = 1.6  # units that a letter is wide where many bars make a view small


@dataclass(frozen=True)
class Bar:
    """One bar: ``value`` in the axis's values, ``text`` behind it; ``deviation`` is its standard error."""

    name: str
    value: float
    text: str
    colour: Colour
    deviation: float | None = None


def sheet_height(count: int) -> float:
    """The height of a sheet that has room for so many bars."""
    return max(HIGH, 32.0 + _ROW * count)


def draw_bars(stream: rr.RecordingStream, at: str, bars: Sequence[Bar], axis: Axis, heading: str) -> Sheet:
    """Draw bars from the axis's low end on below the entity ``at``; names stand above their bars."""
    sheet = Sheet(stream, at, axis, Axis(0.0, 1.0, (), (), heading), sheet_height(len(bars)))
    row = min(1.4 * _ROW, (sheet.bottom - TOP) / max(len(bars), 1))
    for number, bar in enumerate(bars):
        middle = TOP + (number + 0.75) * row
        end = LEFT + (RIGHT - LEFT) * float(np.clip(axis.share(bar.value), 0.0, 1.0))
        first = LEFT + _HALF  # the ends of thick lines are round
        sheet.bar(f"room {number}", [(first, middle), (RIGHT - _HALF, middle)], _HALF, GRID, 5.0)
        if end > first + _HALF:
            sheet.bar(bar.name, [(first, middle), (end - _HALF, middle)], _HALF, bar.colour, 15.0)
        sheet.write_from(LEFT, middle - _HALF - 3.4, f"{bar.name}: {bar.text}", bar.colour, _LETTER)
        if bar.deviation is not None:
            ends = [bar.value - bar.deviation, bar.value + bar.deviation]
            low, high = LEFT + (RIGHT - LEFT) * np.clip(axis.share(np.array(ends)), 0.0, 1.0)
            sheet.bar(f"{bar.name}, standard error", [(low, middle), (high, middle)], 0.3, TEXT, 20.0)
            for x in (low, high):
                cap = [(x, middle - 2.0), (x, middle + 2.0)]
                sheet.bar(f"{bar.name}, standard error to {x:.1f}", cap, 0.3, TEXT, 20.0)
    return sheet
