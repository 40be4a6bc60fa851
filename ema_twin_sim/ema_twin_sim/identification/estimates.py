"""Estimates: the fitted parameters, with their standard errors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..criteria import CALIBRATION, CONTRADICTED, SEARCHED_UP_TO, SMALL
from ..effects import catalogue
from ..model import EffectInstance, Model
from ..model.check_comment import START_VALUE
from ..model.constants import CONSTANTS
from ..model.model_file import ABSENT, TORQUE_CONSTANT
from ..model.own_units import shown_entry, shown_options
from ..model.roles import DRY_FRICTION, TORQUE_FACTOR
from .equation import EquationErrorProblem
from .fit import Fit
from .hypothesis import INERTIAS
from .uncertainty import covariance


def standard_errors(problem: EquationErrorProblem, f: Fit, known: np.ndarray | None = None) -> dict[str, float]:
    """Standard errors of the free parameters, by path; parameters held at a value have none.

    They are those of the fit, or of a ``known`` covariance (k, k).
    """
    known = covariance(problem, f) if known is None else known
    spread = np.sqrt(np.diag(known))
    sure = {free.path: float(s) for free, s in zip(f.hypothesis.free, spread, strict=True) if free.lower < free.upper}
    places = {free.path: k for k, free in enumerate(f.hypothesis.free)}
    now = f.hypothesis.by_path
    for path in (path for path in places if path.startswith("quarter.")):
        id = path.removeprefix("quarter.")
        both = [places[f"scale.{id}"], places[path]]
        along, ahead = now[f"scale.{id}"], now[path]
        size = max(math.hypot(along, ahead), 1e-12)
        for what, slopes in (("scale", (along / size, ahead / size)), ("angle", (-ahead / size**2, along / size**2))):
            variance = float(np.array(slopes) @ known[np.ix_(both, both)] @ np.array(slopes))
            sure[f"{what}.{id}"] = math.sqrt(max(variance, 0.0))
    return sure


def far_off(f: Fit) -> dict[str, float]:
    """By the name of each constant that ended far outside its tolerance: by how much of itself it moved."""
    return {
        free.path.removeprefix("scale.").replace("_", " "): float(value) - 1.0
        for free, value in zip(f.hypothesis.free, f.hypothesis.values, strict=True)
        if free.path.startswith("scale.") and free.prior is not None and abs(value - 1.0) > CONTRADICTED * free.prior[1]
    }


def far_off_in_words(off: Mapping[str, float]) -> list[str]:
    """Warnings about such constants."""
    return [
        f"{name} ended {100.0 * share:+.0f} % off the model's: is that file of this machine, or do these recordings "
        "tell too little of it?"
        for name, share in off.items()
    ]


def off_by_one_factor(constants: Mapping[str, Mapping[str, Mapping[str, Any]]], given: Model) -> list[str]:
    """Warning if all refitted ``constants`` are the same multiple of what the ``given`` model states.

    A machine does not change in this way; a wrong unit of torque or current looks like this. Constants that the
    recordings hardly determine are ignored. A draft states none: its inertia is a start value, and so is its friction,
    which has no source of its own to say so; that they are off by one factor is chance.
    """
    if any(given.constants[path].source == START_VALUE for path in INERTIAS):
        return []
    told: dict[str, float] = {}
    for held in constants.values():
        for name, entry in held.items():
            value, nominal, std = (entry.get(key) for key in ("value", "nominal", "std"))
            if value and nominal and std is not None and std < SMALL * abs(value):
                told["inertia" if name.endswith("inertia") else f"{name} {entry['unit']}"] = value / nominal
    factor = float(np.median([*told.values()])) if told else 1.0
    alike = all(abs(times / factor - 1.0) < SMALL for times in told.values())
    if len(told) < 2 or not alike or 1.0 / SEARCHED_UP_TO < factor < SEARCHED_UP_TO:
        return []
    return [
        f"inertia and friction all ended at {factor:.3g} times the model's: is the unit of the current or torque wrong "
        "(mA that are read as A make it 1000), or is the model another machine's?"
    ]


def parameters(f: Fit, sure: Mapping[str, float]) -> dict[str, dict[str, Any]]:
    """Parameters of the added effects, with unit and standard error."""
    found: dict[str, dict[str, Any]] = {}
    for name, instance in f.hypothesis.model().effects.items():
        if name not in f.hypothesis.added:
            continue
        base = f.hypothesis.base
        entry = {"effect": instance.effect, "options": shown_options(base, instance.options)}
        found[name] = entry | shown_parameters(base, name, instance, sure)
    return found


def shown_parameters(
    base: Model, name: str, instance: EffectInstance, sure: Mapping[str, float]
) -> dict[str, dict[str, object]]:
    """By parameter of an added effect: its value, unit and standard error, ``sure`` telling the errors by path.

    Errors are increased by the difference between two right formulations of the same physics.
    """
    found = {}
    for p in catalogue()[instance.effect].parameters_with(instance.options):
        value, std = instance.parameters[p.name], sure.get(f"effects.{name}.{p.name}")
        told = std if std is None or p.periodic else math.hypot(std, CALIBRATION * value)
        found[p.name] = shown_entry(base, value, told, p.unit, angle=p.periodic)
    return found


def constants(f: Fit, sure: Mapping[str, float], given: Model) -> dict[str, dict[str, dict[str, object]]]:
    """Refitted machine constants and friction of the start model; nominal values are those of the ``given`` model."""
    base, model = f.hypothesis.base, f.hypothesis.model()
    found: dict[str, dict[str, dict[str, object]]] = {}
    for path in (path for path in INERTIAS if base.constants[path].source != ABSENT):
        part, _, name = base.shown_path(path).partition(".")
        std = sure[f"scale.{'output_' if name.startswith('output') and f.hypothesis.parted else ''}inertia"]
        entry = _refitted(base, model.value(path), base.value(path), std, CONSTANTS[path].unit)
        found.setdefault(part, {})[name] = {**entry, "nominal": given.value(path)}
    for path, std in ((path, std) for path, std in sure.items() if path.startswith("contact.")):
        name = path.replace("contact.", "contact_")
        place = f"transmission.{name}"
        entry = shown_entry(base, model.value(place), std, CONSTANTS[place].unit)
        found.setdefault("transmission", {})[name] = {**entry, "nominal": given.value(place)}
    for name, instance in base.effects.items():
        output = instance.options.get("side") == "output" and instance.effect == DRY_FRICTION
        path = "scale.output_coulomb" if output and f.hypothesis.parted else f"scale.{instance.effect}"
        if instance.effect == TORQUE_FACTOR and path in sure:
            value, nominal = model.effects[name].parameters["scale"], base.value(TORQUE_CONSTANT)
            entry = _refitted(base, value * nominal, nominal, sure[path], CONSTANTS[TORQUE_CONSTANT].unit)
            part, _, constant = base.shown_path(TORQUE_CONSTANT).partition(".")
            found.setdefault(part, {})[constant] = {**entry, "nominal": given.value(TORQUE_CONSTANT)}
        elif path in sure:
            p = catalogue()[instance.effect].parameters[0]
            value, began = model.effects[name].parameters[p.name], instance.parameters[p.name]
            entry = _refitted(base, value, began, sure[path], p.unit)
            found.setdefault(name, {})[p.name] = {**entry, "nominal": given.effects[name].parameters[p.name]}
            angle = catalogue()[instance.effect].wave_angle
            if angle is not None and (wobble := sure.get(f"angle.{instance.effect}")) is not None:
                value, nominal = (each.effects[name].parameters[angle.name] for each in (model, base))
                entry = shown_entry(base, value, wobble, angle.unit, angle=True)
                found[name][angle.name] = {**entry, "nominal": nominal}
    return found


def _refitted(base: Model, value: float, began: float, relative_std: float, unit: str) -> dict[str, object]:
    """A value with its standard error, given relative to where its factor began."""
    return shown_entry(base, value, relative_std * abs(began), unit)
