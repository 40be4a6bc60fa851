"""What one answer is worth: named or not, confidently wrong or not, and how near its parameters are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from .cases import ANGLES, Case


@dataclass(frozen=True)
class Verdict:
    """A case and its answer, judged."""

    case: str
    kind: str
    hidden: tuple[str, ...]
    added: tuple[str, ...]
    verdict: str
    found: bool  # exactly what is hidden, and the verdict says so
    first: bool  # the first effect added is a hidden one
    wrong: tuple[str, ...]  # added, not hidden, and in no reported group with a hidden one
    seconds: float
    undecided: bool = False  # not found, but all that is hidden is named or in a group with what is, and nothing wrong
    removed: float = math.nan  # share of the excess current error that went away on the held-out recordings
    errors: Mapping[str, float] = field(default_factory=dict)  # relative error by effect.parameter
    within: Mapping[str, bool] = field(default_factory=dict)  # truth within three reported standard errors
    options: bool | None = None  # whether the hidden effects that were named have the right options
    error: str = ""  # what discovery broke on

    def as_json(self) -> dict[str, Any]:
        """For ``--json``; what is no finite number becomes None."""
        errors = {name: error if math.isfinite(error) else None for name, error in self.errors.items()}
        removed = self.removed if math.isfinite(self.removed) else None
        return {**asdict(self), "errors": errors, "removed": removed}

    def line(self) -> str:
        """One line for the screen."""
        worst = max(self.errors.values(), default=math.nan)
        parts = [
            f"{self.case:24s} {'ok  ' if self.found else 'MISS'} hidden={','.join(self.hidden) or '-'}",
            f"added={','.join(self.added) or '-'} verdict={self.verdict}",
            f"WRONG={','.join(self.wrong)}" if self.wrong else "",
            "other options" if self.options is False else "",
            f"removed={self.removed:.3f} param_err={worst:.3f} {self.seconds:.1f}s",
            self.error,
        ]
        return " ".join(part for part in parts if part)


def judge(case: Case, answer: Mapping[str, Any], seconds: float, removed: float = math.nan) -> Verdict:
    """Judge the JSON that discovery gave for a case.

    Found: exactly the hidden effects are named, and the verdict says so. Wrong: named, not hidden, and in no reported
    group with a hidden one.
    """
    added = tuple(answer["added"])
    said = answer["verdict"]
    hidden = set(case.hidden)
    real = hidden | set(case.tolerated)
    named = set(added) - set(case.tolerated)
    expected = hidden - set(case.tolerated)
    also_right = {"unknown"} if case.restless else set()
    if "unknown" in hidden:
        found = first = not named - hidden and (said == "unknown" or bool(named & hidden))
    elif not expected:
        found = first = not named and said in {"explained" if added else "none"} | also_right
    else:
        found = named == expected and said in {"explained"} | also_right
        first = bool(added) and added[0] in real
    told = named | {id for group in answer.get("groups", ()) if set(group) & named for id in group}
    grouped = {id for group in answer.get("groups", ()) if set(group) & real for id in group}
    wrong = tuple(sorted(set(added) - real - grouped))
    errors, within = _parameters(case, answer)
    return Verdict(
        case=case.name,
        kind=case.kind,
        hidden=tuple(sorted(case.hidden)),
        added=added,
        verdict=said,
        found=found,
        first=first,
        wrong=wrong,
        seconds=seconds,
        undecided=not found and bool(expected) and expected <= told and not wrong,
        removed=removed,
        errors=errors,
        within=within,
        options=_options(case, answer),
    )


def broken(case: Case, error: Exception, seconds: float) -> Verdict:
    """A case that discovery broke on: it is lost, and is shown."""
    words = " ".join(f"{type(error).__name__}: {error}".split())[:300]
    hidden = tuple(sorted(case.hidden))
    return Verdict(case.name, case.kind, hidden, (), "ERROR", False, False, (), seconds, error=words)


def _parameters(case: Case, answer: Mapping[str, Any]) -> tuple[dict[str, float], dict[str, bool]]:
    """(relative errors, truth within three standard errors) of the named effects, by effect.parameter."""
    errors: dict[str, float] = {}
    within: dict[str, bool] = {}
    for (id, name), off, spreads in deviations(case, answer):
        if name not in ANGLES:
            errors[f"{id}.{name}"] = abs(off / case.parameters[id][name])
        within[f"{id}.{name}"] = abs(off) <= 3.0 * sum(spread for spread in spreads if spread is not None)
    return errors, within


def deviations(case: Case, answer: Mapping[str, Any]) -> Iterator[tuple[tuple[str, str], float, list[float | None]]]:
    """((effect, parameter), how far it is off, standard errors of its sides) of what is hidden and named.

    The errors of two sides may add up. A parameter that is not reported is as wrong as can be.
    """
    for id, truth in case.parameters.items():
        if id not in answer["added"]:
            continue
        instances = _instances_of(case, answer, id)
        for name, true in truth.items():
            if name in ANGLES and case.unkind.power_cycled:
                continue
            found = [entry[name] for entry in instances if name in entry]
            off = sum(entry["value"] for entry in found) - true if found else math.inf
            if name in ANGLES and found:
                off = math.remainder(off, 2.0 * math.pi)
            yield (id, name), off, [entry.get("std") for entry in found]


def _instances_of(case: Case, answer: Mapping[str, Any], id: str) -> list[Mapping[str, Any]]:
    """The reported instances that hold an effect's truth: both sides of a friction, else the one most like it."""
    all_of_it = [entry for entry in answer["parameters"].values() if entry.get("effect") == id]
    if id in case.remove_from_stock_model:
        return all_of_it
    options = next(cause.options for cause in case.causes if cause.id == id)
    alike = [entry for entry in all_of_it if _same(entry.get("options", {}), options)]
    return (alike or all_of_it)[:1]


def _same(reported: Mapping[str, Any], true: Mapping[str, str]) -> bool:
    return all(str(reported.get(name, value)) == value for name, value in true.items())


def _options(case: Case, answer: Mapping[str, Any]) -> bool | None:
    """Whether each named hidden effect that has options is reported with the true ones; None where none has any."""
    right = [
        any(
            entry.get("effect") == cause.id and _same(entry.get("options", {}), cause.options)
            for entry in answer["parameters"].values()
        )
        for cause in case.causes
        if cause.options and cause.id in answer["added"]
    ]
    return all(right) if right else None
