"""Check the table of a user's effect: texts, names, numbers and options, before they are used."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from ema_bench_replay.errors import InputError

from ..effects.effect import Effect, Parameter
from ..model.own_units import is_scalable

_NAME = r"[a-z][a-z0-9]*(_[a-z0-9]+)*"
_NAMING = "use small letters, digits and single underscores"


def checked_table(file: Path, effect: Effect) -> Effect:
    """The effect with its numbers as floats and its lists as tuples. Raises InputError if its table is invalid."""
    check = _Check(file)
    check.name(effect.id, "EFFECT.id")
    if re.search(r"_\d+$", effect.id):
        raise check.error("EFFECT.id", f"'{effect.id}' ends like a second instance", "end it with a word")
    for name in ("summary", "equation", "signature", "shown_by", "source"):
        check.text(getattr(effect, name), f"EFFECT.{name}")
    if not effect.parameters:
        raise check.error("EFFECT.parameters", "holds none", "give at least one, the effect's size first")
    parameters = tuple(_checked_parameter(check, parameter, k) for k, parameter in enumerate(effect.parameters))
    options = _checked_options(check, effect.options)
    if effect.law and effect.law not in options:
        raise check.error("EFFECT.law", f"'{effect.law}' is no option", "name one of EFFECT.options, or leave it out")
    if parameters[0].choice:
        place = f"EFFECT.parameters.{parameters[0].name}.choice"
        raise check.error(place, "the first parameter is the effect's size", "leave it out: all laws have it")
    for parameter in parameters:
        if parameter.choice and parameter.choice not in options.get(effect.law, ()):
            place = f"EFFECT.parameters.{parameter.name}.choice"
            raise check.error(place, f"{parameter.choice!r} is no choice of EFFECT.law", "give one, or leave it out")
    names = [parameter.name for parameter in parameters] + list(options)
    for name in names:
        if names.count(name) > 1:
            raise check.error("EFFECT", f"'{name}' names two parameters or options", "rename one")
    for way in ("act", "settle", "settle_winding"):
        if getattr(effect, way) is not None and not callable(getattr(effect, way)):
            raise check.error(f"EFFECT.{way}", "is no function", f"give {way}={way}")
    if not isinstance(effect.electrical, bool):
        raise check.error("EFFECT.electrical", f"is {effect.electrical!r}", "give True or False")
    act = getattr(effect.act, "py_func", effect.act)  # the Python function, if already compiled
    return replace(effect, parameters=parameters, options=options, act=act)


def _checked_parameter(check: _Check, parameter: object, number: int) -> Parameter:
    place = f"EFFECT.parameters[{number}]"
    if not isinstance(parameter, Parameter):
        raise check.error(place, f"is {parameter!r}", "give Parameter(name, unit, default, lower, upper, description)")
    check.name(parameter.name, f"{place}.name")
    if parameter.name == "enabled":
        raise check.error(f"{place}.name", "'enabled' is the effect's switch", "choose another name")
    place = f"EFFECT.parameters.{parameter.name}"
    check.text(parameter.unit, f"{place}.unit", "give a unit, '1' for none")
    if not is_scalable(parameter.unit):
        remedy = (
            "give N m, kg m^2, rad, rev, s, Hz, A, V, ohm, H or K with whole powers, as in N m s/rad, or '1' for none"
        )
        raise check.error(f"{place}.unit", f"'{parameter.unit}' cannot be converted to other machines", remedy)
    check.text(parameter.description, f"{place}.description")
    lower, upper = (check.bound(getattr(parameter, name), f"{place}.{name}") for name in ("lower", "upper"))
    if not lower < upper:
        raise check.error(place, f"lower {lower:g} is not below upper {upper:g}", "give the bounds in order")
    if not isinstance(parameter.starts, (tuple, list)):
        raise check.error(f"{place}.starts", f"is {parameter.starts!r}", "give a tuple of numbers")
    within = {"default": check.number(parameter.default, f"{place}.default")}
    within |= {f"starts[{k}]": check.number(v, f"{place}.starts[{k}]") for k, v in enumerate(parameter.starts)}
    for name, value in within.items():
        if not lower <= value <= upper:
            raise check.error(f"{place}.{name}", f"{value:g} is out of bounds", f"give {lower:g} to {upper:g}")
    for name in ("periodic", "at_rest"):
        if not isinstance(getattr(parameter, name), bool):
            raise check.error(f"{place}.{name}", f"is {getattr(parameter, name)!r}", "give True or False")
    driven = float(parameter.driven) if isinstance(parameter.driven, bool) else parameter.driven
    if not 0.0 <= check.number(driven, f"{place}.driven") <= 1.0:
        raise check.error(f"{place}.driven", f"is {driven:g}", "give a share of the fastest recorded speed, 0 to 1")
    if parameter.neutral is not None:
        check.number(parameter.neutral, f"{place}.neutral")
    default, *starts = within.values()
    shapes = number > 0 or parameter.neutral is None
    anywhere = replace(parameter, lower=lower, upper=upper).is_place  # the recordings tell where to look for it
    if shapes and not starts and not parameter.periodic and not anywhere and math.isinf(upper - lower):
        raise check.error(place, "has no bound, and no values to look for it at", "give starts=(...), or bounds")
    return replace(parameter, default=default, lower=lower, upper=upper, starts=tuple(starts), driven=driven)


def _checked_options(check: _Check, options: object) -> dict[str, tuple[str, ...]]:
    if not isinstance(options, Mapping):
        raise check.error("EFFECT.options", "is no dictionary", "give {name: (choice, choice)}")
    checked = {}
    for name, choices in options.items():
        check.name(name, "EFFECT.options")
        place = f"EFFECT.options.{name}"
        if isinstance(choices, str) or not choices:
            raise check.error(place, f"is {choices!r}", "give a tuple of choices, the default first")
        for choice in choices:
            check.text(choice, place, "give every choice as a text")
        checked[name] = tuple(choices)
    return checked


class _Check:
    """Raises errors that name the file and the place in its table."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def error(self, place: str, what: str, remedy: str) -> InputError:
        return InputError(f"{self._file}: {place}: {what}; {remedy}")

    def text(self, value: object, place: str, remedy: str = "say it in a few words") -> None:
        if not isinstance(value, str) or not value.strip():
            raise self.error(place, f"is {value!r}, no text", remedy)

    def name(self, value: object, place: str) -> None:
        if not isinstance(value, str) or not re.fullmatch(_NAME, value):
            raise self.error(place, f"{value!r} is no name for YAML and ROS", _NAMING)

    def bound(self, value: object, place: str) -> float:
        """A number, or infinity if there is no bound."""
        if isinstance(value, float) and math.isinf(value):
            return value
        return self.number(value, place, "give a number, or math.inf for none")

    def number(self, value: object, place: str, remedy: str = "give a finite number") -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise self.error(place, f"is {value!r}", remedy)
        return float(value)
