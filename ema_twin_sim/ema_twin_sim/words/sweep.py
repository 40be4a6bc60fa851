"""What is said of a sweep, alike in the terminal and on its page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..criteria import SIGNIFICANT
from ..quantities import quantity

if TYPE_CHECKING:
    from ..campaign.sweep_points import DetectionLimit, Swept, SweptPoint

COLUMNS = ("named", "least error", "error told", "errors were")
"""Of a point, beside the numbers that were varied."""


def limit_words(limit: DetectionLimit) -> str:
    """From which size on an effect is named, and below which nothing could be sure of it."""
    named = "at none of these sizes" if limit.named is None else f"from {quantity(limit.named, limit.unit)} on"
    return (
        f"{limit.path} is named {named}; below {quantity(limit.bound, limit.unit)}, {SIGNIFICANT:g} times the least "
        "standard error, no method could be sure of it."
    )


def point_cells(point: SweptPoint) -> tuple[str, ...]:
    """The numbers that were varied, and what COLUMNS names."""
    paths = [path for path, _, _ in point.settings]
    varied = [number for number in point.numbers if number.path in paths]
    return (
        *(quantity(value, unit) for _, value, unit in point.settings),
        "" if point.share is None else f"{point.named}/{point.searched}",
        *(", ".join(_cell(number, what) for number in varied) for what in ("bound", "told", "scatter")),
    )


def _cell(number: Swept, what: str) -> str:
    value: float | None = getattr(number, what)
    return "-" if value is None else quantity(value, number.unit)
