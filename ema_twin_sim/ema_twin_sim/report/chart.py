"""Charts for plotly in the page's own colours; arrays are packed to keep the page small."""

from __future__ import annotations

import base64
import html
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .markup import Markup, tag

Trace = dict[str, Any]

BENCH, BEFORE, AFTER, FITTED, RIVAL, FAINT, BAND = (
    f"@{name}" for name in ("bench", "before", "after", "fitted", "rival", "faint", "band")
)
"""Colours by name: the page's style sheet defines them for a light and for a dark background."""
MODELS = (BEFORE, AFTER, FITTED)
"""The colours of models, the earliest first."""
_OF_THREE = (1.0, 2.0, 0.8)


@dataclass(frozen=True)
class Chart:
    """One chart: traces (of arrays) and layout as plotly takes them, or ``choices`` of both, one per recording.

    Charts with the same ``link`` are zoomed together along their x axes.
    """

    caption: str
    height: int  # pixels
    layout: Mapping[str, Any]
    traces: Sequence[Trace] = ()
    choices: Sequence[Mapping[str, Any]] = ()
    link: str = ""
    wide: bool = False

    def as_json(self) -> dict[str, Any]:
        """The chart as the page's script expects it."""
        content = {"layout": {**self.layout, "height": self.height}, "link": self.link}
        return content | ({"choices": list(self.choices)} if self.choices else {"traces": list(self.traces)})


@dataclass
class Charts:
    """The charts of a page, in the order of their places in it."""

    all: list[Chart] = field(default_factory=list)

    def add(self, chart: Chart) -> Markup:
        """Add a chart; return the element in which it is drawn."""
        place = tag("div", "", class_="chart", data_chart=str(len(self.all)), style=f"min-height:{chart.height}px")
        self.all.append(chart)
        kind = "wide" if chart.wide else "narrow"
        return tag("figure", tag("figcaption", chart.caption), place, class_=kind)

    def as_json(self) -> str:
        """All charts for a script element; ``<`` is escaped, so that no text can end the element."""
        content = [chart.as_json() for chart in self.all]
        text = json.dumps(content, allow_nan=False, separators=(",", ":"), default=_packed)
        return text.replace("<", "\\u003c")


def _packed(values: np.ndarray) -> dict[str, str]:
    """An array (n,) as plotly reads it, in single precision: seven digits are more than a screen shows."""
    return {"dtype": "f4", "bdata": base64.b64encode(np.asarray(values, "<f4").tobytes()).decode()}


def widths(models: int) -> tuple[float, ...]:
    """Line width of each model relative to the usual: the third is drawn thin on top of the second."""
    return _OF_THREE if models > 2 else (1.0, 1.0)


def label(text: str) -> str:
    """Text from a file as a chart's label, escaped because plotly interprets tags."""
    return html.escape(text, quote=False)


def line(
    x: np.ndarray, y: np.ndarray, name: str, colour: str, *, width: float = 1.5, dash: str = "solid", **more: Any
) -> Trace:
    """A curve."""
    style = {"color": colour, "width": width, "dash": dash}
    return {"type": "scatter", "mode": "lines", "x": x, "y": y, "name": label(name), "line": style, **more}


def band(x: np.ndarray, low: np.ndarray, high: np.ndarray, name: str, colour: str) -> list[Trace]:
    """The shaded area between two curves."""
    edges = [line(x, y, name, colour, width=0.0, showlegend=False, hoverinfo="skip") for y in (low, high)]
    edges[1] |= {"fill": "tonexty", "fillcolor": f"{colour}-faint"}
    return edges


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis with its quantity and unit."""
    return {"title": {"text": label(title)}, **more}


def log_axis(title: str, values: np.ndarray) -> dict[str, Any]:
    """A logarithmic axis over the positive ones of ``values``, its ticks at 1, 2 and 5 of each decade."""
    positive = values[values > 0.0]
    low, high = (positive.min(), positive.max()) if len(positive) else (1.0, 10.0)
    decades = range(math.floor(math.log10(low)) - 1, math.ceil(math.log10(high)) + 1)
    ticks = [step * 10.0**decade for decade in decades for step in (1.0, 2.0, 5.0)]
    return axis(title, type="log", tickvals=ticks, ticktext=[f"{tick:g}" for tick in ticks])


def noise_band(floor: float, x: str = "x", y: str = "y") -> dict[str, Any]:
    """A band of two standard deviations of the sensors' noise to either side of zero."""
    place = {"xref": f"{x} domain", "yref": y, "x0": 0, "x1": 1, "y0": -2.0 * floor, "y1": 2.0 * floor}
    return {"type": "rect", **place, "fillcolor": BAND, "line": {"width": 0}, "layer": "below"}
