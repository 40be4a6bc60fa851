"""Horizontal bars, one below another, each with its name on the left and its number on the right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from .palette import GRID, TEXT, Colour
from .sheet import BOTTOM, HIGH, LEFT, TOP, Axis, Sheet, sheet_view

START, END = 74.0, 112.0
"""Where the axis of the bars begins and ends on its sheet: names are on its left, numbers on its right."""
THICKEST = 1.6
"""Maximum half thickness of a bar in units, which is also the radius of its round end."""
_MOST_LETTERS = 42  # of a name
_DOT = 0.01  # units, of the shortest bar between its round ends
_THICK = 0.3  # half thickness, as a share of the row
_LOWEST, _HIGHEST = 5.2, 9.0  # units, height of a row: at least so that numbers do not touch, and at most


@dataclass(frozen=True)
class Bar:
    """One bar: ``value`` in the axis's values, ``text`` to its right; ``deviation`` is its standard error.

    A ``label`` is written on the left in place of the ``name``.
    """

    name: str
    value: float
    text: str
    colour: Colour
    deviation: float | None = None
    label: str | None = None


def _short(name: str) -> str:
    return name if len(name) <= _MOST_LETTERS else f"{name[: _MOST_LETTERS - 1].rstrip(' ,')}…"


def bars_view(at: str, name: str, count: int) -> rrb.Spatial2DView:
    """A view of so many bars as a whole."""
    return sheet_view(at, name, 0.0, HIGH + _below(count))


def _below(count: int) -> float:
    """How much farther down than usual the frame of so many bars reaches, in units."""
    return max(0.0, _LOWEST * count - (BOTTOM - TOP))


def draw_bars(stream: rr.RecordingStream, at: str, bars: Sequence[Bar], axis: Axis, heading: str) -> None:
    """Draw bars that start at the axis's low end, below the entity ``at``."""
    bottom = BOTTOM + _below(len(bars))
    sheet = Sheet(stream, at, axis, Axis(0.0, 1.0, (), (), ""), left=START, right=END, bottom=bottom)
    sheet.write_from(LEFT, 6.0, heading, TEXT)
    row = min(_HIGHEST, (bottom - TOP) / max(len(bars), 1))
    half = min(THICKEST, _THICK * row)
    for number, bar in enumerate(bars):
        middle = TOP + (number + 0.5) * row
        end = START + (END - START) * float(np.clip(axis.share(bar.value), 0.0, 1.0))
        first = START + half  # the ends of thick lines are round
        sheet.bar(f"room {number}", [(first, middle), (END - half, middle)], half, GRID, 5.0)
        if end > START:
            last = max(end - half, first + _DOT)
            sheet.bar(bar.name, [(first, middle), (last, middle)], half, bar.colour, 15.0)
        label, colour = (bar.name, bar.colour) if bar.label is None else (bar.label, TEXT)
        sheet.write_to(START - 1.0, middle, _short(label), colour)
        sheet.write_from(END + 2.0, middle, bar.text, bar.colour)
        if bar.deviation is not None:
            ends = [bar.value - bar.deviation, bar.value + bar.deviation]
            low, high = START + (END - START) * np.clip(axis.share(np.array(ends)), 0.0, 1.0)
            sheet.bar(f"{bar.name}, standard error", [(low, middle), (high, middle)], 0.3, TEXT, 20.0)
            for name, x in (("from", low), ("to", high)):
                cap = [(x, middle - 1.3 * half), (x, middle + 1.3 * half)]
                sheet.bar(f"{bar.name}, standard error, {name}", cap, 0.3, TEXT, 20.0)
    sheet.done()
