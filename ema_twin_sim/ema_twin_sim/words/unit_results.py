"""Words about a unit's results, one by one: the same on the terminal and on its page."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ..campaign.dates import when_words
from ..campaign.unit_health import UnitHealth
from ..campaign.units import Unit
from ..health.judgement import HealthJudgement
from ..health.naming import in_words
from .sentences import effect_words

LAST_ERROR = "error left / noise"
"""Heading of the largest error of a result, in times the sensors' noise."""
DISTANCE = "distance / limit"
"""Heading of how far a recording or a test is from the healthy ones."""
NUMBERS = (LAST_ERROR, DISTANCE)
"""Headings of columns that hold numbers."""
_END = re.compile(r"(?<=[.?]) |; ")
_CHANGE = "largest change (standard deviations)"


def result_columns(unit: Unit, health: UnitHealth | None) -> dict[str, list[str]]:
    """Columns with one cell for each of a unit's results, in their order, without those that are empty."""
    judged = {run.name: run for test in (() if health is None else health.tests) for run in test.runs}
    learnt = health is not None and bool(health.baselines)
    rows = [_cells(unit, row, judged.get(row["name"]) if row["health"] else None, learnt=learnt) for row in unit.rows]
    columns = {heading: [row[heading] for row in rows] for heading in (rows[0] if rows else ())}
    return {heading: cells for heading, cells in columns.items() if any(cells)}


def first_clause(text: str) -> str:
    """The first clause of a text, to be told within another: without its full stop."""
    first = _END.split(text, maxsplit=1)[0].removesuffix(".")
    return f"{first[:1].lower()}{first[1:]}" if first[:4] in ("The ", "Its ") else first


def _cells(unit: Unit, row: Mapping[str, Any], run: HealthJudgement | None, *, learnt: bool) -> dict[str, str]:
    """One result by headings; ``run`` is the judgement of its health, None if it was not judged or learnt from."""
    beyond = unit.beyond(row)
    told = row["verdict"] or row["status"], row["message"] or ""
    if row["health"] and (run or learnt):
        told = _of_reference(row["health"]) if run is None else _of_health(run)
    near = run is not None and run.detected is not None
    return {
        "recording": row["name"],
        "recorded": when_words(row["time"]),
        "task": row["task"],
        "verdict": told[0],
        "missing": ", ".join(effect_words(effect) for effect in row["missing"] or ()),
        LAST_ERROR: "" if beyond is None else f"{beyond:.1f} ×",
        DISTANCE: f"{run.distance:.1f} ×" if run is not None and near else "",
        _CHANGE: _largest(run) if run is not None else "",
        "reason": told[1],
    }


def _of_health(run: HealthJudgement) -> tuple[str, str]:
    """The verdict on a recording that is compared with the healthy ones, and why there is none."""
    if run.detected is None:
        return "not judged", first_clause(run.words[-1])
    return "deviates" if run.detected else "like the healthy ones", ""


def _of_reference(held: Mapping[str, Any]) -> tuple[str, str]:
    """The same for one that belongs to the healthy ones."""
    fit = held["usable"] and held["effort_usable"]
    return ("healthy reference", "") if fit else ("not used as healthy", " ".join(held["findings"] or ()))


def _largest(run: HealthJudgement) -> str:
    """The feature that is farthest from the healthy ones, with its change: *lag +16.2*; empty if there is none."""
    held = in_words(run.changes)
    if not held:
        return ""
    most = max(held, key=lambda change: abs(change.standard_deviations))
    return f"{most.name.replace('_', ' ')} {most.standard_deviations:+.1f}"
