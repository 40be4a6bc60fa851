"""The report's charts drawn on sheets, with the same numbers, colours and titles as on its page."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import rerun as rr

from ..report.chart import Chart, Trace
from .palette import FAINT, QUIET, TEXT, Colour, named
from .sheet import TOP, Axis, Sheet, linear_axis, log_axis, named_axis

_ROOM = 0.06  # share of an axis that is left free beyond what is drawn
_NOISE = "± 2 σ of the sensors' noise"
_LARGE = 8.0  # pixels
_APART = 0.12  # shift between traces, as a share of the distance between two names


def draw(stream: rr.RecordingStream, at: str, chart: Chart) -> Sheet:
    """Draw a chart below the entity ``at``; the sheet takes more words until it is ``done``."""
    x_axis = _axis(chart, "x", [_x(trace) for trace in chart.traces])
    y_axis = _axis(chart, "y", [values for trace in chart.traces for values in _extent(trace)])
    sheet = Sheet(stream, at, x_axis, y_axis)
    _mark(sheet, chart, x_axis, y_axis)
    lower = np.zeros(0)
    for number, trace in enumerate(chart.traces):
        name, colour = f"{number} {_name(trace)}", _colour(trace)
        x, y = _x(trace), np.asarray(trace["y"], np.float64)
        if "error_y" in trace:
            x = x + _APART * number  # so that one model's points do not cover the other's
        if trace.get("fill") == "tonexty":
            sheet.band(name, x, lower, y, named(trace["fillcolor"]))
        elif trace.get("line", {}).get("width", 1.0) == 0.0:
            lower = y
        else:
            _curve(sheet, name, trace, x, y, colour)
    sheet.key(_key(chart))
    return sheet


def _curve(sheet: Sheet, name: str, trace: Trace, x: np.ndarray, y: np.ndarray, colour: Colour) -> None:
    if "error_y" in trace:
        error = trace["error_y"]
        for k in range(len(x)):
            ends = np.array([y[k] - error["arrayminus"][k], y[k] + error["array"][k]])
            sheet.line(f"{name}, quartiles {k}", np.full(2, x[k]), ends, colour, 2.5)
    if "lines" in trace["mode"]:
        sheet.line(name, x, y, colour, trace["line"]["width"], dots=trace["line"].get("dash") == "dot")
    if "markers" in trace["mode"]:
        sheet.dots(f"{name}, points", x, y, colour, trace["marker"].get("size", _LARGE))


def _mark(sheet: Sheet, chart: Chart, x_axis: Axis, y_axis: Axis) -> None:
    """Draw the lines and the band behind the curves, and the words next to them."""
    for number, shape in enumerate(chart.layout.get("shapes", ())):
        if shape["xref"].endswith("domain"):  # along the whole of x
            for end in dict.fromkeys((shape["y0"], shape["y1"])):
                across = np.array([x_axis.low, x_axis.high])
                sheet.line(f"noise {number} {end:g}", across, np.full(2, end), QUIET, 1.2, dots=True)
        else:
            up = np.array([y_axis.low, y_axis.high])
            sheet.line(f"mark {number}", np.full(2, shape["x0"]), up, FAINT, 1.0, dots=True)
    for note in chart.layout.get("annotations", ()):
        if note["xref"].endswith("domain"):
            at = sheet.place(np.array([x_axis.low]), np.array([10.0 ** note["y"] if y_axis.log else note["y"]]))[0]
            sheet.write_from(at[0] + 1.0, at[1] - 3.0, note["text"], QUIET)
        else:
            at = sheet.place(np.array([10.0 ** note["x"] if x_axis.log else note["x"]]), np.array([y_axis.high]))[0]
            sheet.write(at[0], TOP + 3.0, note["text"], TEXT)


def _axis(chart: Chart, way: str, values: Sequence[np.ndarray]) -> Axis:
    """The axis that the chart's layout asks for, over the values (n,) of all traces."""
    layout: Mapping[str, Any] = chart.layout[f"{way}axis"]
    title = layout["title"]["text"]
    names = [name for trace in chart.traces for name in trace[way] if isinstance(name, str)]
    if names:
        return named_axis(list(dict.fromkeys(names)), title)
    if "ticktext" in layout and layout.get("type") != "log":
        words = [html.unescape(word.replace("<br>", ", ")) for word in layout["ticktext"]]
        low, high = layout["range"]
        return Axis(low, high, tuple(map(float, layout["tickvals"])), tuple(words), title)
    if way == "y":
        across = [shape for shape in chart.layout.get("shapes", ()) if shape["xref"].endswith("domain")]
        values = [*values, np.array([shape[end] for shape in across for end in ("y0", "y1")], np.float64)]
    whole = np.concatenate([np.zeros(0), *values])
    whole = whole[np.isfinite(whole)]
    if layout.get("type") == "log":
        positive = whole[whole > 0.0]
        low, high = (positive.min(), positive.max()) if len(positive) else (1.0, 10.0)
        room = (high / low) ** _ROOM if high > low else 2.0
        return log_axis(low / (room if way == "y" else 1.0), high * (room if way == "y" else 1.0), title)
    if "range" in layout:
        low, high = layout["range"]
        return linear_axis(low, high, title)
    low, high = (float(whole.min()), float(whole.max())) if len(whole) else (0.0, 1.0)
    room = _ROOM * (high - low) if way == "y" else 0.0
    return linear_axis(0.0 if layout.get("rangemode") == "tozero" else low - room, high + room, title)


def _x(trace: Trace) -> np.ndarray:
    """Places of a trace's points along x (n,); names are at 0, 1, 2 …"""
    x = trace["x"]
    if len(x) and isinstance(x[0], str):
        return np.arange(len(x), dtype=np.float64)
    return np.asarray(x, np.float64)


def _extent(trace: Trace) -> list[np.ndarray]:
    """The values of a trace that its axis must show."""
    y = np.asarray(trace["y"], np.float64)
    error = trace.get("error_y")
    return [y] if error is None else [y - error["arrayminus"], y + error["array"]]


def _key(chart: Chart) -> list[tuple[str, Colour]]:
    """Legend of the colours, each once; recordings that are drawn one by one share an entry."""
    found: dict[str, Colour] = {}
    for trace in chart.traces:
        if trace.get("showlegend", True):
            colour = _colour(trace)
            name = "each recording" if colour == FAINT else _name(trace).removesuffix(", forward")
            if not name.endswith(", backward"):
                found.setdefault(name, colour)
    if any(shape["type"] == "rect" for shape in chart.layout.get("shapes", ())):
        found[_NOISE] = QUIET
    return list(found.items())


def _name(trace: Trace) -> str:
    return html.unescape(trace["name"])


def _colour(trace: Trace) -> Colour:
    return named(trace["line"]["color"] if "line" in trace else trace["marker"]["color"])
