"""A sheet to draw on in a 2D view: a frame with ticks and titles, lines, bars, points and words.

Rerun plots only scalars over time, so charts against speed or order are drawn. A sheet is ``WIDE`` units wide, and from
``ABOVE`` to ``HIGH`` units high; words keep their size on the screen, whatever the size of the view.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from .palette import QUIET, RULE, TEXT, Colour

WIDE, ABOVE, HIGH = 160.0, -8.0, 91.0
"""The width of a sheet, and where it begins and ends."""
LEFT, RIGHT, TOP, BOTTOM = 21.0, 156.0, 18.0, 71.0
"""The frame's edges, unless it is made narrower."""
_LETTER, _AROUND = 2.0, 4.0  # units, width of a letter and of the space around a word in a view of 640 by 310 pixels
_KEY_LETTER, _KEY_ROOM = 2.5, 5.0  # units, a letter and the room around a word in a view of 400 pixels: no overlaps
_TITLE = -3.5  # place of a sheet's title
_KEY_ROW, _KEY_ROWS = 10.0, (4.0, 11.6)  # places of the legend between a sheet's title and its frame: one row, or two
_ABOVE = 2.4  # units that rerun puts words below their point
_TICKS = 6  # approximate number of ticks


@dataclass(frozen=True)
class Axis:
    """Maps values to places between two edges of the frame; ``ticks`` are in values, ``words`` are their labels."""

    low: float
    high: float
    ticks: tuple[float, ...]
    words: tuple[str, ...]
    title: str
    log: bool = False

    def share(self, values: np.ndarray | float) -> np.ndarray:
        """Where values lie between the low end (0) and the high end (1)."""
        along = np.asarray(values, np.float64)
        if self.log:
            with np.errstate(divide="ignore", invalid="ignore"):
                along = np.log10(along)
            return (along - math.log10(self.low)) / (math.log10(self.high) - math.log10(self.low))
        return (along - self.low) / (self.high - self.low)


def linear_axis(low: float, high: float, title: str) -> Axis:
    """An axis with round ticks."""
    if not high > low:
        low, high = low - 0.5, high + 0.5
    raw = (high - low) / _TICKS
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= raw)
    ticks = tuple(step * k for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1))
    return Axis(low, high, ticks, tuple(f"{tick:.6g}".replace("-", "−") for tick in ticks), title)


def log_axis(low: float, high: float, title: str) -> Axis:
    """A logarithmic axis with ticks at 1, 2 and 5 of each decade, or only at decades if there are many."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    factors = (1.0, 2.0, 5.0) if len(decades) <= 4 else (1.0,)
    ticks = tuple(f * 10.0**d for d in decades for f in factors if low <= f * 10.0**d <= high)
    return Axis(low, high, ticks, tuple(f"{tick:g}" for tick in ticks), title, log=True)


def named_axis(names: Sequence[str], title: str) -> Axis:
    """An axis of names at 0, 1, 2 …"""
    places = tuple(float(k) for k in range(len(names)))
    return Axis(-0.5, len(names) - 0.5, places, tuple(names), title)


def sheet_view(at: str, name: str, first: float = ABOVE, last: float = HIGH) -> rrb.Spatial2DView:
    """A view of a sheet as a whole, from its ``first`` unit to its ``last`` one."""
    bounds = rrb.VisualBounds2D(x_range=[0.0, WIDE], y_range=[first, last])
    return rrb.Spatial2DView(origin=at, name=name, visual_bounds=bounds)


class Sheet:
    """Draws below the entity ``at`` of a stream; everything is static.

    The frame reaches from ``left`` to ``right`` and down to ``bottom``.
    """

    def __init__(
        self,
        stream: rr.RecordingStream,
        at: str,
        x: Axis,
        y: Axis,
        *,
        left: float = LEFT,
        right: float = RIGHT,
        bottom: float = BOTTOM,
    ) -> None:
        self._stream, self._at, self._x, self._y = stream, at, x, y
        self._left, self._right, self._bottom = left, right, bottom
        self._words: list[tuple[float, float, str, Colour]] = []
        self._frame()

    def _frame(self) -> None:
        corners = [
            [self._left, TOP],
            [self._right, TOP],
            [self._right, self._bottom],
            [self._left, self._bottom],
            [self._left, TOP],
        ]
        at_x = [float(v) for v in self._left + (self._right - self._left) * self._x.share(np.array(self._x.ticks))]
        at_y = [float(v) for v in self._bottom - (self._bottom - TOP) * self._y.share(np.array(self._y.ticks))]
        grid = [[[x, TOP], [x, self._bottom]] for x in at_x] + [[[self._left, y], [self._right, y]] for y in at_y]
        self._log("grid", rr.LineStrips2D(grid, colors=[RULE], radii=[-0.4], draw_order=0.0))
        self._log("frame", rr.LineStrips2D([corners], colors=[QUIET], radii=[-0.7], draw_order=1.0))
        for x, word in zip(at_x, self._x.words, strict=True):
            self.write(x, self._bottom + _ABOVE + 2.5, word, QUIET)
        for y, word in zip(at_y, self._y.words, strict=True):
            self.write_to(self._left - 1.0, y, word, QUIET)
        self.write(0.5 * (self._left + self._right), self._bottom + 13.0, self._x.title, TEXT)
        self.write_from(self._left, _TITLE, self._y.title, TEXT)

    def place(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Values (n,) as points (n, 2) of the sheet, limited to the frame."""
        across = self._left + (self._right - self._left) * np.clip(self._x.share(x), 0.0, 1.0)
        up = self._bottom - (self._bottom - TOP) * np.clip(self._y.share(y), 0.0, 1.0)
        return np.column_stack(np.broadcast_arrays(across, up))

    def line(
        self, name: str, x: np.ndarray, y: np.ndarray, colour: Colour, width: float, *, dots: bool = False
    ) -> None:
        """A curve through the finite values (n,), ``width`` in pixels; ``dots`` divides it into short pieces."""
        good = np.isfinite(x) & np.isfinite(y)
        points = self.place(x[good], y[good])
        if len(points) < 2:
            return
        strips = _pieces(points) if dots else [points]
        self._log(name, rr.LineStrips2D(strips, colors=[colour], radii=[-0.5 * width], draw_order=20.0))

    def band(self, name: str, x: np.ndarray, low: np.ndarray, high: np.ndarray, colour: Colour) -> None:
        """The filled area between two curves (n,)."""
        good = np.isfinite(x) & np.isfinite(low) & np.isfinite(high)
        below, above = self.place(x[good], low[good]), self.place(x[good], high[good])
        if len(below) < 2:
            return
        across = np.linspace(below[0, 0], below[-1, 0], 240)
        bottom, top = (np.interp(across, points[:, 0], points[:, 1]) for points in (below, above))
        strips = np.stack([np.column_stack([across, bottom]), np.column_stack([across, top])], axis=1)
        half = 0.7 * (across[1] - across[0])
        self._log(name, rr.LineStrips2D(strips, colors=[colour], radii=[half], draw_order=10.0))

    def bar(self, name: str, ends: Sequence[tuple[float, float]], half: float, colour: Colour, order: float) -> None:
        """A thick line between two points of the sheet, ``half`` units to either side; a higher ``order`` is above."""
        self._log(name, rr.LineStrips2D([ends], colors=[colour], radii=[half], draw_order=order))

    def dots(self, name: str, x: np.ndarray, y: np.ndarray, colour: Colour, size: float) -> None:
        """Points, ``size`` pixels across."""
        good = np.isfinite(x) & np.isfinite(y)
        points = self.place(x[good], y[good])
        self._log(name, rr.Points2D(points, colors=[colour], radii=[-0.5 * size], draw_order=30.0))

    def write(self, x: float, y: float, text: str, colour: Colour) -> None:
        """Words centred at a point of the sheet."""
        if text:
            self._words.append((x, y - _ABOVE, text, colour))

    def write_from(self, x: float, y: float, text: str, colour: Colour) -> None:
        """Words that begin at a point of the sheet."""
        self.write(x + 0.5 * (_LETTER * len(text) + _AROUND), y, text, colour)

    def write_to(self, x: float, y: float, text: str, colour: Colour) -> None:
        """Words that end at a point of the sheet."""
        self.write(x - 0.5 * (_LETTER * len(text) + _AROUND), y, text, colour)

    def key(self, entries: Sequence[tuple[str, Colour]]) -> None:
        """Legend of the colours, above the frame and up to its right edge, in two rows if one is too narrow."""
        room = self._right - self._left
        rows: list[list[tuple[str, Colour]]] = [[]]
        for entry in entries:
            if rows[-1] and sum(map(_key_width, [*rows[-1], entry])) > room and len(rows) < len(_KEY_ROWS):
                rows.append([])
            rows[-1].append(entry)
        for y, row in zip(_KEY_ROWS if len(rows) > 1 else (_KEY_ROW,), rows, strict=True):
            share = min(1.0, room / max(sum(map(_key_width, row)), 1.0))
            x = self._right
            for text, colour in reversed(row):
                width = share * _key_width((text, colour))
                self.write(x - 0.5 * width, y, text, colour)
                x -= width

    def done(self) -> None:
        """Write all words."""
        places = [[x, y] for x, y, *_ in self._words]
        texts, colours = [text for _, _, text, _ in self._words], [colour for *_, colour in self._words]
        words = rr.Points2D(places, labels=texts, colors=colours, radii=[0.0], show_labels=True, draw_order=40.0)
        self._log("words", words)

    def _log(self, name: str, content: rr.AsComponents) -> None:
        self._stream.log(f"{self._at}/{rr.escape_entity_path_part(name)}", content, static=True)


def _key_width(entry: tuple[str, Colour]) -> float:
    return _KEY_LETTER * len(entry[0]) + _KEY_ROOM


def _pieces(points: np.ndarray, length: float = 1.2) -> list[np.ndarray]:
    """A curve's points (n, 2) as short pieces with gaps of the same length."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.arange(0.0, along[-1], 0.5 * length)
    x, y = (np.interp(at, along, points[:, k]) for k in (0, 1))
    fine = np.column_stack([x, y])
    return [fine[k : k + 3] for k in range(0, len(fine) - 1, 4)]
