"""Recordings that stand under several units: a file with a wrong serial number, or a folder that was copied."""

from __future__ import annotations

from collections.abc import Iterable

from ..listing import listed, number_of
from .results import DONE
from .units import Unit

_SHOWN = 4
"""Number of units that are named."""


def copies_across(units: Iterable[Unit], of: str | None = None) -> list[str]:
    """One warning that names the first recording whose samples several units have, and how many there are; else none.

    ``of`` asks for those of one unit only. A copy within one unit is among that unit's remarks.
    """
    of_content: dict[str, dict[str, str]] = {}
    for unit in units:
        for row in unit.rows:
            for content in (row["content"] or ()) if row["status"] == DONE else ():
                of_content.setdefault(content, {}).setdefault(unit.name, row["name"])
    copies = [its for its in of_content.values() if len(its) > 1 and (of is None or of in its)]
    if not copies:
        return []
    first = sorted(copies[0].items(), key=lambda place: (place[0] != of, place[0]))
    places = [f"{unit} ({name})" for unit, name in first[:_SHOWN]]
    places += [f"{len(first) - _SHOWN} more"] if len(first) > _SHOWN else []
    concerned = {unit for places in copies for unit in places}
    begin = (
        f"a recording stands under {listed(places)} with the same samples"
        if len(copies) == 1
        else f"{number_of(len(copies), 'recording')} of {number_of(len(concerned), 'unit')} stand under several units "
        f"with the same samples, the first under {listed(places)}"
    )
    return [f"{begin}: a recording belongs to one unit, so its other results mislead; correct the folders or --unit"]
