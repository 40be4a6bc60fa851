"""Measured against both twins, with what is left over below, a recording at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..comparison.compare import Signals
from ..quantities import axis_unit
from .beside import Beside
from .chart import AFTER, BEFORE, BENCH, Chart, Charts, axis, line, noise_band
from .content import Content, Shown, signal_words
from .envelope import envelope_rows
from .markup import Markup, capitalised, section, tag

SHOWN = ("output_position", "current", "motor_torque", "speed", "motor_position", "unexplained_torque")
MOST = 3  # signals that are drawn
_BUDGET = 280_000  # numbers of all curves, so that a page stays below 4 MB of them
_MOST_POINTS = 4000  # of a curve: a screen shows no more
_FEWEST_POINTS = 300


def compared(content: Content, charts: Charts) -> Markup:
    """The section with the curves."""
    parts = [content.given, *([content.held_out] if content.held_out else [])]
    names = [recording.name for part in parts for recording in part.recordings]
    held_out = len(names) - len(content.given.recordings)
    options = [
        tag("option", f"{name} (held out)" if k >= len(names) - held_out else name, value=str(k), **chosen)
        for k, name in enumerate(names)
        for chosen in ([{"selected": ""}] if k == content.given.telling else [{}])
    ]
    choice = tag("label", "Recording ", tag("select", *options, id="recording"), class_="choice")
    key = _key(content.names)
    signals = signals_drawn(content.given)
    points = max(_FEWEST_POINTS, min(_MOST_POINTS, _BUDGET // (6 * len(names) * max(1, len(signals)))))
    figures = [
        charts.add(_chart(name, parts, content.names, points, wide=place == 0 and len(signals) != 2))
        for place, name in enumerate(signals)
    ]
    longest = max(len(recording) for part in parts for recording in part.recordings)
    drawn = " Of long recordings, the least and the largest of each stretch are drawn." if longest > points else ""
    how = f"Drag in a plot to zoom, all follow in time; double-click to see all again.{drawn}"
    return section(
        "compare",
        "Measured against twin",
        tag("div", choice, key, class_="controls"),
        tag("div", *figures, class_="grid"),
        tag("p", how, class_="aside screen"),
    )


def _key(names: tuple[str, str]) -> Markup:
    """What the colours mean; each entry hides and shows its curves."""
    entries = [
        tag(
            "button", tag("span", "", class_=f"swatch {role}"), name, type="button", data_role=role, aria_pressed="true"
        )
        for role, name in (("bench", "measured"), ("before", names[0]), ("after", names[1]))
    ]
    band = tag("span", tag("span", "", class_="swatch band"), "two standard deviations of the sensors' noise")
    return tag("div", *entries, band, class_="key")


def signals_drawn(given: Shown) -> list[str]:
    """The signals that are drawn, the first of which tells most."""
    there = [name for name in SHOWN if name in given.signals and any(name in each.curves for each in given.curves[0])]
    return there[:MOST]


def _chart(name: str, parts: Sequence[Shown], names: tuple[str, str], points: int, *, wide: bool) -> Chart:
    errors: list[Signals] = [recording.signals for part in parts for recording in part.comparisons[0].recordings]
    pairs = [pair for part in parts for pair in zip(part.curves[0], part.curves[1], strict=True)]
    choices = [_choice(name, *pair, error, names, points) for pair, error in zip(pairs, errors, strict=True)]
    title = signal_words(name)
    caption = f"{capitalised(title)}: measured and both twins; below, measured minus twin"
    layout = {"xaxis": {"anchor": "y2"}, "yaxis": {"domain": [0.46, 1.0]}, "yaxis2": {"domain": [0.0, 0.40]}}
    return Chart(
        caption,
        380,
        layout,
        choices=choices,
        link="time",
        wide=wide,
    )


def _choice(
    name: str, before: Beside, after: Beside, errors: Signals, names: tuple[str, str], points: int
) -> dict[str, Any]:
    """What is drawn of one recording; nothing where it lacks the signal."""
    if name not in before.curves or name not in after.curves:
        lacks = {
            "text": f"this recording has no {signal_words(name)}",
            "showarrow": False,
            "xref": "paper",
            "yref": "paper",
        }
        return {"traces": [], "layout": {"annotations": [{**lacks, "x": 0.5, "y": 0.5}]}}
    values, order, along = abscissa(before)
    first, second = before.curves[name], after.curves[name]
    rows = order[envelope_rows([curve[order] for curve in (first.measured, first.residual, second.residual)], points)]
    at = values[rows]
    whole, unit = axis_unit(_largest(first.measured), first.unit)
    small, of_residual = axis_unit(max(_largest(first.residual), _largest(second.residual)), first.unit)
    measured = first.measured[rows]
    mode = {"mode": "markers", "marker": {"size": 4}} if before.of_points else {}

    def curve(values: np.ndarray, role: str, title: str, axis_name: str, width: float) -> dict[str, Any]:
        return line(at, values, title, role, width=width, yaxis=axis_name, meta=role.removeprefix("@"), **mode)

    traces = [
        curve(measured / whole, BENCH, "measured", "y", 2.5),
        curve((measured - first.residual[rows]) / whole, BEFORE, names[0], "y", 1.4),
        curve((measured - second.residual[rows]) / whole, AFTER, names[1], "y", 1.4),
        curve(first.residual[rows] / small, BEFORE, names[0], "y2", 1.2),
        curve(second.residual[rows] / small, AFTER, names[1], "y2", 1.2),
    ]
    if name == "unexplained_torque":
        traces[0]["name"] = "torque of the motor, measured"
    layout = {
        "xaxis": axis(along),
        "yaxis": axis(f"{signal_words(name)} [{unit}]"),
        "yaxis2": axis(f"residual [{of_residual}]"),
        "shapes": [noise_band(errors[name]["noise_floor"] / small, "x", "y2")],
    }
    return {"traces": traces, "layout": layout}


def abscissa(shown: Beside) -> tuple[np.ndarray, np.ndarray, str]:
    """What curves are drawn over (n,), the order (n,) of their samples along it, and its title."""
    if not shown.of_points:
        return shown.time, np.arange(len(shown.time)), "time [s]"
    if shown.motor_position is not None and np.ptp(shown.motor_position) > 0.0:
        return shown.motor_position, np.argsort(shown.motor_position, kind="stable"), f"motor position [{shown.way}]"
    return shown.speed, np.argsort(shown.speed, kind="stable"), f"motor speed [{shown.way}/s]"


def _largest(values: np.ndarray) -> float:
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max()) if len(finite) else 0.0
