"""Curves of measurement and twin, and below them the residual with the band of the sensors' noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..quantities import axis_unit, signal_words
from ..report.beside import Beside, Curves
from ..report.compared import abscissa, signals_drawn
from ..report.content import Shown
from .palette import MEASURED, MODELS, QUIET
from .stream import path_of, send, send_level, style

ROOT = "compare"
_FOR_THE_LEGEND, _BELOW = 0.45, 0.05  # of the curves' height, left free above and below them
_TYPICAL = 0.98  # quantile of a residual that determines the unit of its axis


def log_curves(stream: rr.RecordingStream, given: Shown, names: Sequence[str]) -> None:
    """Send the curves of every recording; ``names`` are the models' names."""
    for number, recording in enumerate(given.comparisons[0].recordings):
        for name, curves in _drawn(given, number):
            at, floor = path_of(ROOT, recording.name, name), recording.signals[name]["noise_floor"]
            _log_signal(stream, at, given.curves[0][number], curves, names, floor)


def _drawn(given: Shown, number: int) -> list[tuple[str, list[Curves]]]:
    """The signals that are drawn of a recording, each with the curves of all models."""
    besides = [recordings[number] for recordings in given.curves]
    names = [name for name in signals_drawn(given) if all(name in beside.curves for beside in besides)]
    return [(name, [beside.curves[name] for beside in besides]) for name in names]


def _log_signal(
    stream: rr.RecordingStream, at: str, of: Beside, curves: Sequence[Curves], models: Sequence[str], floor: float
) -> None:
    along, order, _ = abscissa(of)
    time = (along - along.min() if of.of_points else along)[order]
    scale, unit = residual_unit(curves)
    style(stream, f"{at}/curves/measured", f"measured [{curves[0].unit}]", MEASURED, 2.5)
    send(stream, f"{at}/curves/measured", time, curves[0].measured[order])
    for model, curve, colour in zip(models, curves, MODELS, strict=False):
        twin = path_of(f"twin {model}")
        style(stream, f"{at}/curves{twin}", f"twin: {model}", colour, 1.5)
        send(stream, f"{at}/curves{twin}", time, (curve.measured - curve.residual)[order])
        style(stream, f"{at}/residual{twin}", f"− twin: {model}", colour, 1.2)
        send(stream, f"{at}/residual{twin}", time, curve.residual[order] / scale)
    style_noise(stream, f"{at}/residual", unit)
    send_noise(stream, f"{at}/residual", time, floor / scale)


def residual_unit(curves: Sequence[Curves]) -> tuple[float, str]:
    """Divisor of residuals for a readable axis, and their unit then."""
    sizes = [float(np.nanquantile(np.abs(c.residual), _TYPICAL)) for c in curves if np.isfinite(c.residual).any()]
    return axis_unit(max(sizes, default=0.0), curves[0].unit)


def style_noise(stream: rr.RecordingStream, at: str, unit: str) -> None:
    """Set how the band of the sensors' noise is drawn: two lines below ``at``."""
    for side in ("above", "below"):
        style(stream, f"{at}/noise_{side}", f"± sensors' noise [{unit}]", QUIET, 1.5)


def send_noise(stream: rr.RecordingStream, at: str, time: np.ndarray, floor: float) -> None:
    """Extend that band over the times [s] (n,): one standard deviation to either side."""
    send_level(stream, f"{at}/noise_above", time, floor)
    send_level(stream, f"{at}/noise_below", time, -floor)


def curves_tab(given: Shown) -> rrb.Container:
    """One tab per recording, in front the one with the largest error of the earlier model; one column per signal."""
    tabs = []
    for number, recording in enumerate(given.comparisons[0].recordings):
        first = given.curves[0][number]
        along = abscissa(first)[2] if first.of_points else ""
        columns: list[rrb.Container] = []
        for name, curves in _drawn(given, number):
            at, unit, small = path_of(ROOT, recording.name, name), curves[0].unit, residual_unit(curves)[1]
            room = None if columns else _room(curves)
            columns.append(signal_column(at, name, unit, small, along, legend=not columns, room=room))
        tabs.append(rrb.Horizontal(*columns, name=recording.name))
    return rrb.Tabs(*tabs, active_tab=given.telling, name="compare")


def _room(curves: Sequence[Curves]) -> tuple[rrb.ScalarAxis, rrb.ScalarAxis]:
    """The axes of a signal and of its residual with room above the curves, so that the legend covers none of them."""
    scale = residual_unit(curves)[0]
    signal = [values for each in curves for values in (each.measured, each.measured - each.residual)]
    return _with_room(signal), _with_room([each.residual / scale for each in curves])


def _with_room(curves: Sequence[np.ndarray]) -> rrb.ScalarAxis:
    finite = [values[np.isfinite(values)] for values in curves]
    low, high = (
        float(pick([end(values) for values in finite if len(values)] or [0.0]))
        for pick, end in ((min, np.min), (max, np.max))
    )
    size = (high - low) or 1.0
    return rrb.ScalarAxis(range=(low - _BELOW * size, high + _FOR_THE_LEGEND * size))


def signal_column(
    at: str,
    name: str,
    unit: str,
    residual_unit: str,
    along: str = "",
    tab: str | None = None,
    *,
    legend: bool = True,
    room: tuple[rrb.ScalarAxis, rrb.ScalarAxis] | None = None,
) -> rrb.Container:
    """One signal above, its residual below; ``along`` is the quantity shown as time, ``tab`` the name as a tab.

    Of columns side by side one has a ``legend``, with axes that have ``room`` for it.
    """
    over = f" over {along}, 1 s per unit" if along else ""
    words = signal_words(name, unit)
    above = f"{words} [{unit}]: measured and twin{over}"
    below = f"{words}: measured − twin [{residual_unit}]"
    together = rrb.TimeAxis(link="LinkToGlobal")
    key = rrb.PlotLegend(rrb.Corner2D.RightTop, visible=legend)
    of_signal, of_residual = room or (None, None)
    return rrb.Vertical(
        rrb.TimeSeriesView(origin=f"{at}/curves", name=above, axis_x=together, axis_y=of_signal, plot_legend=key),
        rrb.TimeSeriesView(origin=f"{at}/residual", name=below, axis_x=together, axis_y=of_residual, plot_legend=key),
        name=tab,
    )
