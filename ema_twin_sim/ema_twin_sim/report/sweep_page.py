"""A page of a sweep: a curve where one number was varied, a map where two were, and all points as a table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ema_bench_replay.outputs import new_file

from ..campaign.sweep_points import DetectionLimit, SweptPoint
from ..quantities import quantity
from ..words.sweep import COLUMNS, limit_words, point_cells
from .fleet import page_text
from .markup import Markup, joined, section, table, tag

_WIDTH, _HEIGHT, _LEFT, _BELOW = 560.0, 260.0, 70.0, 44.0


def write_sweep_page(
    path: Path, points: Sequence[SweptPoint], limit: DetectionLimit | None, *, force: bool = False
) -> Path:
    """Write it. Raises InputError where the file exists (without ``force``) or cannot be written."""
    count = sum(point.results for point in points)
    parts = [tag("p", f"{len(points)} points, {count} results.", class_="lead")]
    if limit is not None:
        parts.append(tag("p", limit_words(limit)))
    axes = len(points[0].settings) if points else 0
    if axes in (1, 2):
        draw = _curve if axes == 1 else _map
        figures = [draw(points, [point.share for point in points], "share of the results in which it was named")]
        figures += [
            draw(points, relative(points, k), f"least standard error of {path}, as a share of its value")
            for k, (path, _, _) in enumerate(points[0].settings)
        ]
        parts.append(section("map", "Map", tag("div", *filter(None, figures), class_="grid")))
    parts.append(section("points", "Points", _table(points)))
    with new_file(path, force=force) as file:
        file.write(page_text("Sweep", joined(parts)).encode())
    return path


def relative(points: Sequence[SweptPoint], axis: int) -> list[float | None]:
    """The bound of the number that an axis is, in times its value; None where it has none."""
    found: list[float | None] = []
    for point in points:
        path, value, _ = point.settings[axis]
        bound = next((number.bound for number in point.numbers if number.path == path), None)
        found.append(None if bound is None or value == 0.0 else bound / abs(value))
    return found


def _table(points: Sequence[SweptPoint]) -> Markup:
    paths = [path for path, _, _ in points[0].settings] if points else []
    return table((*paths, *COLUMNS), [point_cells(point) for point in points], words=())


def _curve(points: Sequence[SweptPoint], values: Sequence[float | None], title: str) -> Markup | None:
    known = [(point.settings[0][1], value) for point, value in zip(points, values, strict=True) if value is not None]
    if len(known) < 2:
        return None
    x, y = (np.array(column) for column in zip(*known, strict=True))
    across, up = _scaled(x, _LEFT, _WIDTH - 12.0), _scaled(np.append(y, 0.0), _HEIGHT - _BELOW, 12.0)
    line = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, up[:-1], strict=True))
    dots = [
        tag("circle", cx=f"{a:.1f}", cy=f"{b:.1f}", r="3.5", fill="var(--after)")
        for a, b in zip(across, up[:-1], strict=True)
    ]
    path, _, unit = points[0].settings[0]
    return _figure(
        title,
        tag("polyline", points=line, fill="none", stroke="var(--after)", stroke_width="2"),
        *dots,
        *_ends(f"{path}: {quantity(float(x.min()), unit)}", quantity(float(x.max()), unit)),
        tag("text", f"{y.max():.3g}", x=f"{_LEFT - 8.0}", y="18", text_anchor="end"),
        tag("text", "0", x=f"{_LEFT - 8.0}", y=f"{_HEIGHT - _BELOW}", text_anchor="end"),
    )


def _map(points: Sequence[SweptPoint], values: Sequence[float | None], title: str) -> Markup | None:
    known = np.array([np.nan if value is None else value for value in values])
    if not np.isfinite(known).any():
        return None
    x, y = (np.array([point.settings[k][1] for point in points]) for k in (0, 1))
    columns, rows = len(np.unique(x)), len(np.unique(y))
    a_grid = columns * rows == len(points)
    wide = (_WIDTH - _LEFT - 12.0) / max(columns, 1) if a_grid else 10.0
    high = (_HEIGHT - _BELOW - 12.0) / max(rows, 1) if a_grid else 10.0
    places = (np.searchsorted(np.unique(x), x), np.searchsorted(np.unique(y), y)) if a_grid else (None, None)
    least, most = float(np.nanmin(known)), float(np.nanmax(known))
    cells = []
    for k, value in enumerate(known):
        if not np.isfinite(value):
            continue
        if places[0] is not None and places[1] is not None:
            left, top = _LEFT + wide * places[0][k], _HEIGHT - _BELOW - high * (places[1][k] + 1)
        else:
            left = float(_scaled(x, _LEFT, _WIDTH - 24.0)[k])
            top = float(_scaled(y, _HEIGHT - _BELOW - 12.0, 12.0)[k])
        depth = 0.1 + 0.9 * ((value - least) / (most - least) if most > least else 0.5)
        told = ", ".join(f"{path} {quantity(v, unit)}" for path, v, unit in points[k].settings)
        cells.append(
            tag(
                "rect",
                tag("title", f"{told}: {value:.3g}"),
                x=f"{left:.1f}",
                y=f"{top:.1f}",
                width=f"{wide:.1f}",
                height=f"{high:.1f}",
                fill="var(--after)",
                fill_opacity=f"{depth:.2f}",
            )
        )
    (first, _, of_first), (second, _, of_second) = points[0].settings
    return _figure(
        f"{title}: {least:.3g} (pale) to {most:.3g}",
        *cells,
        *_ends(f"{first}: {quantity(float(x.min()), of_first)}", quantity(float(x.max()), of_first)),
        tag(
            "text",
            f"up: {second}, {quantity(float(y.min()), of_second)} to {quantity(float(y.max()), of_second)}",
            x=f"{_LEFT}",
            y=f"{_HEIGHT - 6.0}",
        ),
    )


def _scaled(values: np.ndarray, low: float, high: float) -> np.ndarray:
    span = float(np.ptp(values)) or 1.0
    return np.asarray(low + (high - low) * (values - values.min()) / span)


def _ends(first: str, last: str) -> list[Markup]:
    y = f"{_HEIGHT - _BELOW + 18.0}"
    return [tag("text", first, x=f"{_LEFT}", y=y), tag("text", last, x=f"{_WIDTH - 12.0}", y=y, text_anchor="end")]


def _figure(title: str, *parts: Markup) -> Markup:
    drawing = tag(
        "svg",
        *parts,
        viewBox=f"0 0 {_WIDTH:.0f} {_HEIGHT:.0f}",
        role="img",
        font_size="12",
        fill="var(--quiet)",
        aria_label=title,
    )
    return tag("figure", tag("figcaption", title), drawing)
