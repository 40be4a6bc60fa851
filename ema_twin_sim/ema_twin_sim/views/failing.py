"""Where it fails: residuals against speed, position, direction and order, with the orders named."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..quantities import quantity
from ..report.residual_charts import Failures
from .drawn_chart import draw
from .palette import TEXT
from .sheet import RIGHT, TOP, sheet_view

ROOT = "where_it_fails"
_SHARES, _SHARES_OF_THREE = [2, 1], [3, 2]
"""Relative widths of the charts and the words: the column of amplitudes grows with every model."""
_PLACES = ("speed", "output_position", "direction")
_STANDS_OUT = 2.0  # times the median amplitude of the orders near it; above that an order is a peak
_ABOUT = 0.25  # half width of "near", as a natural logarithm of the ratio of orders


def log_failures(
    stream: rr.RecordingStream, found: Sequence[Failures], said: Sequence[str], names: Sequence[str]
) -> None:
    """Draw each signal's charts, and write what they say."""
    for each in found:
        at = f"{ROOT}/{each.signal}"
        for place, chart in zip(_PLACES, each.charts, strict=True):
            draw(stream, f"{at}/{place}", chart).done()
        if each.orders is not None:
            _log_orders(stream, f"{at}/order", each)
        text = rr.TextDocument(_told(each, said, names), media_type=rr.MediaType.MARKDOWN)
        stream.log(f"{at}/told", text, static=True)


def _log_orders(stream: rr.RecordingStream, at: str, each: Failures) -> None:
    """Draw the spectrum, and label the named order with the highest peak, if it stands out from the orders near it."""
    orders = each.orders
    assert orders is not None
    sheet = draw(stream, at, orders.chart)
    first = orders.chart.traces[0]
    clear = [
        (peaks[0] / orders.scale, order, name)
        for order, name, peaks in orders.named
        if peaks[0] / orders.scale > _STANDS_OUT * _usual(first["x"], first["y"], order)
    ]
    for peak, order, name in sorted(clear)[-1:]:
        x, y = sheet.place(np.array([order]), np.array([peak]))[0]
        sheet.write(min(x, RIGHT - len(name)), max(y - 3.0, TOP + 8.0), f"{name} ({order:g})", TEXT)
    sheet.done()


def _usual(orders: np.ndarray, amplitudes: np.ndarray, order: float) -> float:
    """The median amplitude near an order; infinite if the spectrum has none there."""
    about = amplitudes[np.abs(np.log(orders / order)) < _ABOUT]
    return float(np.median(about)) if len(about) else np.inf


def _told(each: Failures, said: Sequence[str], names: Sequence[str]) -> str:
    """Text and one table: what the error depends on, and the machine's own orders."""
    lines = ["## Where it fails", ""]
    lines += [f"**{name}**: {text}\n" for name, text in zip(names, said, strict=True)]
    lines += ["Line: median. Shaded: between the quartiles. Dots: moving backward.", ""]
    if each.orders is not None and each.orders.named:
        lines += [
            "### The machine's own orders",
            "",
            f"Cycles per turn of the motor; the numbers stand above the spectrum. Amplitude: {' → '.join(names)}.",
            "",
            "| order | cycles | amplitude |",
            "|---|---|---|",
        ]
        for number, (order, name, peaks) in enumerate(each.orders.named, 1):
            sizes = " → ".join(quantity(peak, each.orders.unit) for peak in peaks)
            lines.append(f"| {number}: {name} | {order:g} | {sizes} |")
    return "\n".join(lines)


def failing_tab(found: Sequence[Failures], models: int) -> rrb.Container:
    """One tab per signal: up to four charts, and next to them their description; ``models`` is the number of models."""
    tabs = []
    for each in found:
        at, words = f"{ROOT}/{each.signal}", each.words
        views = [sheet_view(f"{at}/{place}", f"{words} against {place.removeprefix('output_')}") for place in _PLACES]
        if each.orders is not None:
            views.append(sheet_view(f"{at}/order", f"{words} against order"))
        told = rrb.TextDocumentView(origin=f"{at}/told", name="in words")
        tabs.append(
            rrb.Horizontal(
                rrb.Grid(*views, grid_columns=2),
                told,
                column_shares=_SHARES_OF_THREE if models > 2 else _SHARES,
                name=words,
            )
        )
    return rrb.Tabs(*tabs, name="where it fails")
