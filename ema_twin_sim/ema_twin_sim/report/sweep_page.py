"""A page of a sweep: a curve if one number was varied, a map if two were, and a table of all points."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ema_bench_replay.outputs import write_text

from ..campaign.sweep_points import DetectionLimit, SweptPoint
from ..listing import number_of
from ..quantities import quantity
from ..words.sweep import columns, limit_words, point_cells
from .chart import AFTER, Chart, Charts, Trace, axis, label, line, log_axis
from .markup import Markup, joined, section, table, tag
from .whole_page import whole_page

_HEIGHT = 300  # pixels
_MOST_NAMED = 10  # levels of an axis
_SHADES = [[0.0, f"{AFTER}-faint"], [1.0, AFTER]]


def write_sweep_page(
    path: Path, points: Sequence[SweptPoint], limit: DetectionLimit | None, *, lost: int = 0,
    ratios: frozenset[str] = frozenset(), force: bool = False,
) -> Path:  # fmt: skip
    """Write the page; ``lost`` points have no result, and the numbers in ``ratios`` have a logarithmic axis.

    Raises InputError if the file exists (without ``force``) or cannot be written.
    """
    count = sum(point.results for point in points)
    charts = Charts()
    others = f" Not shown, since refused or failed: {number_of(lost, 'point')}." if lost else ""
    lead = f"{number_of(len(points), 'point')}, {number_of(count, 'result')}.{others}"
    parts = [tag("h1", "Sweep"), tag("p", lead, class_="lead")]
    if limit is not None:
        parts.append(tag("p", limit_words(limit)))
    axes = len(points[0].settings) if points else 0
    if axes in (1, 2):
        draw = _curve if axes == 1 else _map
        shares = [point.share for point in points]
        figures = [draw(points, shares, "share of the results in which it was found", ratios)]
        figures += [
            draw(points, relative(points, k), f"lowest standard error of {path}, as a share of its value", ratios)
            for k, (path, _, _) in enumerate(points[0].settings)
        ]
        parts.append(section("map", "Map", tag("div", *map(charts.add, filter(None, figures)), class_="grid")))
    parts.append(section("points", "Points", _table(points)))
    write_text(path, whole_page("Sweep", joined(parts), charts=charts), force=force)
    return path


def relative(points: Sequence[SweptPoint], axis: int) -> list[float | None]:
    """The bound of the number along an axis, relative to its value; None if there is none."""
    found: list[float | None] = []
    for point in points:
        path, value, _ = point.settings[axis]
        bound = next((number.bound for number in point.numbers if number.path == path), None)
        found.append(None if bound is None or value == 0.0 else bound / abs(value))
    return found


def _table(points: Sequence[SweptPoint]) -> Markup:
    paths = [path for path, _, _ in points[0].settings] if points else []
    told = columns(points)
    return table((*paths, *told), [point_cells(point, told) for point in points], words=())


def _curve(
    points: Sequence[SweptPoint], values: Sequence[float | None], title: str, ratios: frozenset[str]
) -> Chart | None:
    """Chart of the values over the varied number."""
    known = [(point.settings[0][1], value) for point, value in zip(points, values, strict=True) if value is not None]
    if len(known) < 2:
        return None
    x, y = (np.array(column) for column in zip(*known, strict=True))
    path, _, unit = points[0].settings[0]
    layout = {"xaxis": _axis(path, unit, x, ratios), "yaxis": axis("", rangemode="tozero")}
    return Chart(title, _HEIGHT, layout, [line(x, y, title, AFTER, mode="lines+markers")])


def _map(
    points: Sequence[SweptPoint], values: Sequence[float | None], title: str, ratios: frozenset[str]
) -> Chart | None:
    """Chart of the values over both varied numbers: cells of a grid, or scattered points."""
    known = [(point, value) for point, value in zip(points, values, strict=True) if value is not None]
    if not known:
        return None
    sizes = np.array([value for _, value in known])
    told = [", ".join(f"{path} {quantity(v, unit)}" for path, v, unit in point.settings) for point, _ in known]
    words = [label(f"{text}: {size:.3g}") for text, size in zip(told, sizes, strict=True)]
    shown = {"text": words, "hoverinfo": "text"}
    levels = [np.unique([point.settings[k][1] for point in points]) for k in (0, 1)]
    at = [np.array([point.settings[k][1] for point, _ in known]) for k in (0, 1)]
    names = [(path, unit) for path, _, unit in points[0].settings]
    if len(levels[0]) * len(levels[1]) == len(points):
        x, y = (np.searchsorted(found, placed) for found, placed in zip(levels, at, strict=True))
        trace: Trace = {"type": "heatmap", "x": x, "y": y, "z": sizes, "colorscale": _SHADES, **shown}
        across, up = (_axis_of_levels(*name, found) for name, found in zip(names, levels, strict=True))
    else:
        marker = {"color": sizes, "colorscale": _SHADES, "size": 10, "showscale": True}
        trace = {"type": "scatter", "mode": "markers", "x": at[0], "y": at[1], "marker": marker, **shown}
        across, up = (_axis(*name, placed, ratios) for name, placed in zip(names, at, strict=True))
    return Chart(title, _HEIGHT, {"xaxis": across, "yaxis": up}, [trace])


def _axis_of_levels(path: str, unit: str, levels: np.ndarray) -> dict[str, object]:
    """An axis along which levels (n,) are equally spaced, with as many labels as can be read."""
    named = range(0, len(levels), -(-len(levels) // _MOST_NAMED))
    return axis(path, tickvals=[*named], ticktext=[quantity(float(levels[k]), unit) for k in named])


def _axis(path: str, unit: str, values: np.ndarray, ratios: frozenset[str]) -> dict[str, object]:
    """An axis of a number and its unit, logarithmic if its path is in ``ratios``."""
    title = path if unit == "1" else f"{path} [{unit}]"
    return log_axis(title, values) if path in ratios else axis(title)
