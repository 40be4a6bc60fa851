"""Findings of a fit about its parameters: on a bound, without effect, inseparable, implausible."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..criteria import CONTRADICTED, LIKELY, NEARLY_ALL, PART
from ..effects import Circumstances, catalogue
from ..identification.on_bound import INERTIA_SHOWN_BY, reached_bound, with_unit
from ..model import Model
from .equation_misfit import BLIND, LAG
from .free_parameters import FreeParameter, split
from .plausibility import implausible
from .solver import Solution
from .uncertainty import Uncertainty


@dataclass(frozen=True)
class Finding:
    """A warning: its kind, and the instance (for a constant: its part) and parameter that it is about."""

    kind: str  # on_bound, no_effect, inseparable, absurd; recording: damaged recording
    instance: str
    parameter: str
    message: str


def find(solution: Solution, sure: Uncertainty, fitted: Model, method: str, c: Circumstances) -> list[Finding]:
    """All findings on a solution, in the order of its parameters."""
    found = []
    groups = _groups(solution, sure)
    alike = {k for group in groups for k in group}
    numbers = solution.freedom.numbers
    for k, number in enumerate(numbers):
        if number.path == LAG:
            continue
        value = float(solution.values[k])
        std = float(sure.std[k]) * number.slope(value)
        bound = reached_bound(value, number.lower, number.upper, std, number.scale)
        if bound:
            text = f"ends on its {bound} bound, {with_unit(fitted, value, number.unit, angle=number.periodic)}"
            found.append(_finding("on_bound", number, text, fitted))
        reason = _unseen(number, _shown(solution, k), fitted, method)
        if reason is None and k not in alike:
            reason = _needless(number, value, std, fitted)
        if reason:
            found.append(_finding("no_effect", number, reason, fitted))
        if not number.path.startswith("effects."):
            off = abs(value / number.prior[0] - 1.0)
            tolerance = max(fitted.constants[path].tolerance for path in number.paths)
            if off > CONTRADICTED * tolerance:
                text = (
                    f"ends {100.0 * off:.0f} % off its nominal value, {off / tolerance:.0f} times its tolerance: is "
                    "the model that of this machine, or does an effect stand in its place?"
                )
                found.append(_finding("absurd", number, text, fitted))
    for group in groups:
        *first, last = (".".join(_place(numbers[k].path, fitted)) for k in group)
        names = f"{', '.join(first)} and {last}"
        text = f"{names} cannot be told apart by these recordings: what one gains the others lose; hold one (--fix)"
        found += [Finding("inseparable", *_place(numbers[k].path, fitted), text) for k in group]
    for name, instance in fitted.effects.items():
        if instance.enabled:
            for parameter, reason in implausible(instance.effect, instance.parameters, c):
                free = solution.freedom.index(f"effects.{name}.{parameter}")
                if free is not None:
                    number = numbers[free]
                    written = with_unit(fitted, instance.parameters[parameter], number.unit, angle=number.periodic)
                    message = f"{name}.{parameter} = {written}: {reason}"
                    found.append(Finding("absurd", name, parameter, message))
    return found


def not_given(solution: Solution, method: str) -> list[int]:
    """The constants that neither the recordings nor the model file determine."""
    freedom = solution.freedom
    return [
        k
        for k, number in enumerate(freedom.numbers)
        if not number.path.startswith("effects.")
        and number.path != LAG
        and not number.known
        and _unseen(number, _shown(solution, k), freedom.model, method)
    ]


def asleep(given: Model, judged: Model) -> list[Finding]:
    """For each effect that operating points cannot show: that it was left unchanged, and what would show it."""
    return [
        Finding(
            "no_effect", name, "",
            f"{name} stays as it is: these operating points do not show it; record "
            f"{catalogue()[instance.effect].shown_by}",
        )
        for name, instance in given.active.items()
        if name not in judged.active
    ]  # fmt: skip


def _place(path: str, model: Model) -> tuple[str, str]:
    """(instance, parameter) of an effect's path, (part, name) of a constant's, as named in the model file."""
    part, name, parameter = split(model.shown_path(path))
    return (name, parameter) if part == "effects" else (part, name)


def _finding(kind: str, number: FreeParameter, text: str, model: Model) -> Finding:
    instance, parameter = _place(number.path, model)
    return Finding(kind, instance, parameter, f"{instance}.{parameter} {text}")


def _shown(solution: Solution, k: int) -> float:
    """Effect of a parameter on the rows, in standard deviations per unit of it."""
    return float(np.linalg.norm(solution.slopes[:, k]))


def _unseen(number: FreeParameter, shown: float, model: Model, method: str) -> str | None:
    """Why these recordings do not show a parameter, and what would; ``shown`` is in std deviations per unit of it."""
    change = 1.0 if number.periodic else (math.log(2.0) if number.log else number.scale)
    if shown * change >= LIKELY:
        return None
    part, name, parameter = split(number.path)
    if part != "effects":
        if method == "equation" and number.path.startswith(BLIND):
            return "does not stand in the equation: fit with --method simulation"
        remedy = f"record {INERTIA_SHOWN_BY}" if "inertia" in name else "leave it as it is"
        return f"changes nothing that these recordings show; {remedy}"
    effect = catalogue()[model.effects[name].effect]
    if any(p.at_rest for p in effect.parameters if p.name == parameter):
        return "shows at standstill only, which a fit leaves out; read it off the break-away of a slow start"
    size = effect.parameters[0]
    small = f" while {size.name} is so small" if parameter != size.name and size.neutral is not None else ""
    return f"changes nothing that these recordings show{small}; record {effect.shown_by}"


def _needless(number: FreeParameter, value: float, std: float, model: Model) -> str | None:
    """Why a size is not significantly different from none; None if it is, or if the model file gives it."""
    part, name, parameter = split(number.path)
    if part != "effects" or number.known:
        return None
    effect = catalogue()[model.effects[name].effect]
    size = effect.parameters[0]
    if parameter != size.name or size.neutral is None or abs(value - size.neutral) >= LIKELY * std:
        return None
    found = " ± ".join(with_unit(model, told, number.unit, angle=number.periodic) for told in (value, std))
    return (
        f"= {found} is no more than its standard error: these recordings do not need it; record "
        f"{effect.shown_by}, or remove {name}"
    )


def _groups(solution: Solution, sure: Uncertainty) -> list[list[int]]:
    """Groups of two or more parameters that these recordings cannot separate.

    Some combination of a group's parameters is poorly determined: a nearly flat direction of the correlation matrix.
    For two parameters this means a correlation above ``NEARLY_ALL``.
    """
    numbers = solution.freedom.numbers
    loose = [
        float(sure.std[k]) * n.slope(float(v)) > PART * _size(n, float(v))
        for k, (n, v) in enumerate(zip(numbers, solution.values, strict=True))
    ]
    named = [k for k, n in enumerate(numbers) if n.path != LAG]
    sizes, directions = np.linalg.eigh(sure.correlation[np.ix_(named, named)])
    groups: list[set[int]] = []
    for size, direction in zip(sizes, directions.T, strict=True):
        if size > 1.0 - NEARLY_ALL:
            break  # eigenvalues are in rising order
        group = {named[k] for k in np.flatnonzero(np.abs(direction) > PART)}
        if any(loose[k] for k in group):
            apart = [other for other in groups if not other & group]
            groups = [*apart, group.union(*(other for other in groups if other & group))]
    return [sorted(group) for group in groups if len(group) > 1]


def _size(number: FreeParameter, value: float) -> float:
    """Size that a standard error is compared with: 1 rad for an angle, otherwise the typical size."""
    return 1.0 if number.periodic else (abs(value) if number.log else number.scale)
