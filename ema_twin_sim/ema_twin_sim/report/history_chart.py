"""Drawing of a number over time: values with standard errors, the healthy level, the limit, and where it changed."""

from __future__ import annotations

import numpy as np

from ..campaign.histories import Outlook
from ..quantities import axis_unit
from .markup import Markup, tag

_WIDTH, _HEIGHT, _LEFT, _BELOW, _ABOVE = 440.0, 170.0, 58.0, 24.0, 8.0
_MARGIN = 0.06  # of the range, above and below


def history_chart(look: Outlook) -> Markup:
    """The drawing as SVG, with time in days or results along x."""
    of = look.history
    low, high = of.values - of.errors, of.values + of.errors
    levels = [look.healthy, *([] if look.limit is None else [look.limit])]
    least, most = min(low.min(), *levels), max(high.max(), *levels)
    room = _MARGIN * (most - least) or 1.0
    least, most = least - room, most + room
    last = float(of.times[-1]) or 1.0

    def x(time: float) -> str:
        return f"{_LEFT + (_WIDTH - _LEFT - 8.0) * time / last:.1f}"

    def y(value: float) -> str:
        return f"{_ABOVE + (_HEIGHT - _BELOW - _ABOVE) * (most - value) / (most - least):.1f}"

    def level(value: float, color: str, dashes: str) -> Markup:
        return tag(
            "line", x1=x(0.0), x2=x(last), y1=y(value), y2=y(value), stroke=color, stroke_width="1.5",
            stroke_dasharray=dashes,
        )  # fmt: skip

    plain = of.unit == "1"
    scale, unit = (1.0, "") if plain else axis_unit(float(np.abs([least, most]).max()), of.unit)
    parts = [level(look.healthy, "var(--good)", "none")]
    if look.limit is not None:
        parts.append(level(look.limit, "var(--before)", "6 4"))
    if look.change is not None:
        begun = x(float(of.times[look.change.begin]))
        parts.append(tag("line", x1=begun, x2=begun, y1=y(most), y2=y(least), stroke="var(--faint)"))
    for time, value, below, above in zip(of.times, of.values, low, high, strict=True):
        at = x(float(time))
        parts.append(tag("line", x1=at, x2=at, y1=y(float(below)), y2=y(float(above)), stroke="var(--after)"))
        parts.append(tag("circle", cx=at, cy=y(float(value)), r="2.5", fill="var(--after)"))
    for value in (most - room, least + room):
        shown = f"{float(f'{value / scale:.3g}'):g}"  # 8840, not 8.84e+03, which has no room
        parts.append(tag("text", shown, x=f"{_LEFT - 6.0}", y=y(value), text_anchor="end", dominant_baseline="middle"))
    parts.append(tag("text", unit, x="2", y=f"{_HEIGHT - 6.0}"))
    end = f"{last:.0f} {'days' if of.dated else 'results'}"
    parts.append(tag("text", end, x=f"{_WIDTH - 8.0}", y=f"{_HEIGHT - 6.0}", text_anchor="end"))
    return tag(
        "svg", *parts, viewBox=f"0 0 {_WIDTH:.0f} {_HEIGHT:.0f}", role="img", font_size="11", fill="var(--quiet)",
        aria_label=f"{of.path} over time",
    )  # fmt: skip
