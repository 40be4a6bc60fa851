"""Curves of measurement and twins with the residuals below, one recording at a time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..comparison.compare import Signals
from ..quantities import axis_unit, signal_words
from .axis_limits import hides_the_rest, limit_words, range_beside
from .beside import Beside
from .chart import BENCH, MODELS, Chart, Charts, axis, line, noise_band, widths
from .content import Content, Shown
from .envelope import envelope_rows
from .markup import Markup, capitalised, section, swatch, tag

SHOWN = (
    "output_position", "current", "motor_torque", "speed", "motor_position", "unexplained_torque", "encoder_difference",
)  # fmt: skip
MOST = 3  # signals that are drawn
_BUDGET = 280_000  # numbers in all curves of a page, which keeps them below 4 MB
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
    key = _key(content.labels)
    signals = signals_drawn(content.given)
    arrays = 2 + 2 * len(content.models)  # of a plot of one recording: time, measurement, and two for each twin
    points = max(_FEWEST_POINTS, min(_MOST_POINTS, _BUDGET // (arrays * len(names) * max(1, len(signals)))))
    figures = [
        charts.add(_chart(name, content, parts, points, wide=place == 0 and len(signals) != 2))
        for place, name in enumerate(signals)
    ]
    longest = max(len(recording) for part in parts for recording in part.recordings)
    drawn = " Long recordings are drawn as minimum and maximum of each interval." if longest > points else ""
    over = " If the fitted model hardly differs, its thin line is on top of the thick line of the found model."
    drawn += over if len(content.models) > 2 else ""
    how = f"Drag in a plot to zoom (all plots follow in time); double-click to reset.{drawn}"
    return section(
        "compare",
        "Measured against twin",
        tag("div", choice, key, class_="controls"),
        tag("div", *figures, class_="grid"),
        tag("p", how, class_="aside screen"),
    )


def _key(names: Sequence[str]) -> Markup:
    """Legend of the colours; each entry hides and shows its curves."""
    roles = [colour.removeprefix("@") for colour in (BENCH, *MODELS)]
    entries = [
        tag(
            "button", tag("span", "", class_=f"swatch {role}"), name, type="button", data_role=role, aria_pressed="true"
        )
        for role, name in zip(roles, ("measured", *names), strict=False)
    ]
    return tag("div", *entries, swatch("band", "two standard deviations of the sensors' noise"), class_="key")


def signals_drawn(given: Shown) -> list[str]:
    """The signals that are drawn, the most informative first."""
    there = [name for name in SHOWN if name in given.signals and any(name in each.curves for each in given.curves[0])]
    return there[:MOST]


def _chart(name: str, content: Content, parts: Sequence[Shown], points: int, *, wide: bool) -> Chart:
    names, limited = content.labels, any(hides_the_rest(part, content.models[0], name) for part in parts)
    errors: list[Signals] = [recording.signals for part in parts for recording in part.comparisons[0].recordings]
    besides = [each for part in parts for each in zip(*part.curves, strict=True)]
    choices = [
        _choice(name, each, error, names, points, limited=limited) for each, error in zip(besides, errors, strict=True)
    ]
    title = content.given.words(name)
    twins = "both twins" if len(names) == 2 else "all twins"
    caption = f"{capitalised(title)}: measured and {twins}; below, measured minus twin"
    caption += limit_words(names[0]) if limited else ""
    layout = {"xaxis": {"anchor": "y2"}, "yaxis": {"domain": [0.46, 1.0]}, "yaxis2": {"domain": [0.0, 0.40]}}
    return Chart(caption, 380, layout, choices=choices, link="time", wide=wide)


def _choice(
    name: str, besides: Sequence[Beside], errors: Signals, names: Sequence[str], points: int, *, limited: bool
) -> dict[str, Any]:
    """Traces and layout of one recording; only a note if it lacks the signal."""
    if any(name not in beside.curves for beside in besides):
        text = f"this recording has no {signal_words(name)}"
        lacks = {"text": text, "showarrow": False, "xref": "paper", "yref": "paper"}
        return {"traces": [], "layout": {"annotations": [{**lacks, "x": 0.5, "y": 0.5}]}}
    values, order, along = abscissa(besides[0])
    twins = [beside.curves[name] for beside in besides]
    first = twins[0]
    drawn = [first.measured, *(twin.residual for twin in twins)]
    rows = order[envelope_rows([curve[order] for curve in drawn], points)]
    at = values[rows]
    whole, unit = axis_unit(_largest(first.measured), first.unit)
    small, of_residual = axis_unit(
        max(_largest(twin.residual) for twin in (twins[1:] if limited else twins)), first.unit
    )
    measured = first.measured[rows]
    mode: dict[str, Any] = {"mode": "markers", "marker": {"size": 4}} if besides[0].of_points else {}

    def curve(values: np.ndarray, role: str, title: str, axis_name: str, width: float) -> dict[str, Any]:
        return line(at, values, title, role, width=width, yaxis=axis_name, meta=role.removeprefix("@"), **mode)

    above = [curve(measured / whole, BENCH, "measured", "y", 2.5)]
    below = []
    for twin, colour, title, width in zip(twins, MODELS, names, widths(len(names)), strict=False):
        residual = twin.residual[rows]
        above.append(curve((measured - residual) / whole, colour, title, "y", 1.4 * width))
        below.append(curve(residual / small, colour, title, "y2", 1.2 * width))
    if name == "unexplained_torque":
        above[0]["name"] = f"{signal_words('torque', first.unit)} of the motor, measured"
    floor = errors[name]["noise_floor"] / small
    layout = {
        "xaxis": axis(along),
        "yaxis": axis(f"{signal_words(name, first.unit)} [{unit}]", **(range_beside(above) if limited else {})),
        "yaxis2": axis(f"residual [{of_residual}]", **(range_beside(below, 2.0 * floor) if limited else {})),
        "shapes": [noise_band(floor, "x", "y2")],
    }
    return {"traces": [*above, *below], "layout": layout}


def abscissa(shown: Beside) -> tuple[np.ndarray, np.ndarray, str]:
    """The values of the x axis (n,), the order (n,) of the samples along it, and its title."""
    if not shown.of_points:
        return shown.time, np.arange(len(shown.time)), "time [s]"
    if shown.motor_position is not None and np.ptp(shown.motor_position) > 0.0:
        return shown.motor_position, np.argsort(shown.motor_position, kind="stable"), f"motor position [{shown.way}]"
    return shown.speed, np.argsort(shown.speed, kind="stable"), f"motor speed [{shown.way}/s]"


def _largest(values: np.ndarray) -> float:
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max()) if len(finite) else 0.0
