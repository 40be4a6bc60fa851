"""Results of a sweep, point by point: how often the missing effects were named, and errors next to their bounds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..criteria import MOSTLY, SIGNIFICANT
from .angles import is_angle, within_half_a_turn
from .results import DONE
from .sweep import VERB


@dataclass(frozen=True)
class Swept:
    """One number of a point: its true value and standard errors, in its SI ``unit``."""

    path: str
    unit: str
    value: float
    bound: float | None  # the least standard error (Cramér-Rao); None if the number was held
    told: float | None  # median of the standard errors that the search gives; None if it estimated none
    scatter: float | None  # root mean square of the estimates' errors; None if it estimated none


@dataclass(frozen=True)
class SweptPoint:
    """The results of one point, over several seeds."""

    settings: tuple[tuple[str, float, str], ...]  # path, value, unit
    results: int
    searched: int
    named: int  # results in which all that the model lacked was found missing
    others: int  # results in which something else was
    lacked: tuple[str, ...]  # the effects that the model lacked
    numbers: tuple[Swept, ...]  # those that were varied first, then the others

    @property
    def share(self) -> float | None:
        """Share of the searches that named all missing effects; None if nothing was missing or nothing was searched."""
        return self.named / self.searched if self.lacked and self.searched else None

    def as_json(self) -> dict[str, object]:
        """SI units; absent numbers are null."""
        return {
            "settings": [{"path": path, "value": value, "unit": unit} for path, value, unit in self.settings],
            "results": self.results,
            "lacked": list(self.lacked),
            "named": self.share,
            "others_named": self.others,
            "numbers": [vars(number) for number in self.numbers],
        }


def swept_points(rows: Iterable[Mapping[str, Any]]) -> list[SweptPoint]:
    """Group the results of a sweep into points, by their settings."""
    by: dict[tuple[tuple[str, float, str], ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        if row["task"] == VERB and row["status"] == DONE:
            by.setdefault(tuple((s["path"], s["value"], s["unit"]) for s in row["settings"] or ()), []).append(row)
    return [_point(settings, its) for settings, its in sorted(by.items())]


def _point(settings: tuple[tuple[str, float, str], ...], rows: Sequence[Mapping[str, Any]]) -> SweptPoint:
    lacked = tuple(dict.fromkeys(effect for row in rows for effect in row["lacked"] or ()))
    searched = [row for row in rows if row["verdict"] is not None]
    found = [{*(row["missing"] or ())} for row in searched]
    varied = {path for path, _, _ in settings}
    numbers: dict[str, list[tuple[Mapping[str, Any], Mapping[str, Any] | None]]] = {}
    for row in rows:
        estimates = {f"{p['owner']}.{p['name']}": p for p in row["parameters"] or ()}
        for bound in row["bounds"] or ():
            path = f"{bound['owner']}.{bound['name']}"
            numbers.setdefault(path, []).append((bound, estimates.get(path)))
    told = [_number(path, its) for path, its in numbers.items()]
    return SweptPoint(
        settings,
        len(rows),
        len(searched),
        sum(names >= {*lacked} for names in found) if lacked else 0,
        sum(bool(names - {*lacked}) for names in found),
        lacked,
        tuple(sorted(told, key=lambda number: number.path not in varied)),
    )


def _number(path: str, its: Sequence[tuple[Mapping[str, Any], Mapping[str, Any] | None]]) -> Swept:
    bounds = [bound["std"] for bound, _ in its if bound["std"] is not None]
    estimates = [(bound["value"], found) for bound, found in its if found is not None and found["value"] is not None]
    stds = [found["std"] for _, found in estimates if found["std"] is not None]
    off = np.array([found["value"] - true for true, found in estimates])
    if is_angle(path):
        off = within_half_a_turn(off)
    return Swept(
        path,
        its[0][0]["unit"],
        its[0][0]["value"],
        float(np.median(bounds)) if bounds else None,
        float(np.median(stds)) if stds else None,
        float(np.sqrt(np.mean(off**2))) if len(off) else None,
    )


@dataclass(frozen=True)
class DetectionLimit:
    """The smallest size of an effect that is named, and the smallest that any method could detect."""

    path: str
    unit: str
    bound: float  # SIGNIFICANT times the least standard error, at the smallest size
    named: float | None  # the smallest size from which on a share MOSTLY of the results name it; None: no such size


def detection_limit(points: Sequence[SweptPoint]) -> DetectionLimit | None:
    """The detection limit, if a single number of a missing effect was varied; else None."""
    if not points or any(len(point.settings) != 1 or point.share is None for point in points):
        return None
    path, _, unit = points[0].settings[0]
    bound = next((number.bound for number in points[0].numbers if number.path == path), None)
    if any(point.settings[0][0] != path for point in points) or bound is None:
        return None
    named = None
    for point in reversed(points):
        if point.share is None or point.share < MOSTLY:
            break
        named = point.settings[0][1]
    return DetectionLimit(path, unit, SIGNIFICANT * bound, named)
