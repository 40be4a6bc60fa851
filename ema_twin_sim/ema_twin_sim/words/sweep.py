"""Words about a sweep, the same on the terminal and on its page."""

from __future__ import annotations

from collections.abc import Sequence

from ..campaign.sweep_points import DetectionLimit, Swept, SweptPoint
from ..criteria import SIGNIFICANT
from ..quantities import quantity

_COLUMNS = {"lowest error": "bound", "reported error": "told", "actual error": "scatter"}


def columns(points: Sequence[SweptPoint]) -> tuple[str, ...]:
    """The columns after the varied numbers; only the bounds if no point was searched."""
    return ("found", *_COLUMNS) if any(point.searched for point in points) else ("lowest error",)


def meaning(points: Sequence[SweptPoint]) -> str:
    """A sentence on what these columns hold."""
    bound = "Lowest error: Cramér-Rao bound of the standard error."
    searched = "Reported: standard error given by the search. Actual: RMS error of its estimates."
    return f"{bound} {searched}" if len(columns(points)) > 1 else bound


def limit_words(limit: DetectionLimit) -> str:
    """A sentence on the size from which an effect is named, and that below which no method could be sure of it."""
    found = "at none of these sizes" if limit.named is None else f"from {quantity(limit.named, limit.unit)} on"
    return (
        f"{limit.path} is found {found}; below {quantity(limit.bound, limit.unit)}, {SIGNIFICANT:g} times the lowest "
        "standard error, no method can detect it reliably."
    )


def point_cells(point: SweptPoint, columns: Sequence[str]) -> tuple[str, ...]:
    """The cells of a point: the varied numbers, then in each of ``columns`` the values for these numbers in order."""
    held = {number.path: number for number in point.numbers}
    varied = [held.get(path) for path, _, _ in point.settings]
    return (
        *(quantity(value, unit) for _, value, unit in point.settings),
        *(_named(point) if column == "found" else _cells(varied, _COLUMNS[column]) for column in columns),
    )


def _named(point: SweptPoint) -> str:
    return "" if point.share is None else f"{point.named}/{point.searched}"


def _cells(varied: Sequence[Swept | None], what: str) -> str:
    values: list[float | None] = [None if number is None else getattr(number, what) for number in varied]
    return ", ".join(
        "-" if value is None or number is None else quantity(value, number.unit)
        for number, value in zip(varied, values, strict=True)
    )
