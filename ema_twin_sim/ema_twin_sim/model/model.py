"""A model: a machine's constants and its assumed effects. Immutable; changes return a new model."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from ema_bench_replay.checked_yaml import decimal_comma
from ema_bench_replay.errors import InputError
from ema_bench_replay.units import unit_in

from ..effects import Effect, Parameter, find_effect
from ..effects.catalogue import is_own
from ..effects.effect import OUTPUT_TORQUE, POSITIVE, range_words
from .constants import CONSTANTS

if TYPE_CHECKING:
    from .own_units import OwnUnits

POLE_PAIRS = "pole pairs"  # name of the order of the electrical angle
ORDER_ERROR = 0.03  # cycles per turn within which an order gets a name
_HARMONICS = 12  # highest multiple of a named order that is named after it
LUMPED = "inertia"
"""Name of the single inertia of a machine without a gearbox that would split it."""


@dataclass(frozen=True)
class ConstantValue:
    """The value of a constant: SI unit as in ``constants.CONSTANTS``, relative tolerance (one standard deviation).

    If it is unknown (open), the tolerance is infinite, and the value is the start of a fit.
    """

    value: float
    tolerance: float = 0.05
    source: str = ""

    def at(self, value: float) -> ConstantValue:
        """The same constant with another value."""
        return ConstantValue(value, self.tolerance, self.source)


ENABLED = "enabled"
"""Last part of the path of an effect's switch."""


@dataclass(frozen=True)
class EffectInstance:
    """One effect in a model: all options and parameters by name.

    If it is ``open``, the values are unknown: they are the start of a fit.
    """

    effect: str
    options: Mapping[str, str]
    parameters: Mapping[str, float]
    enabled: bool = True
    open: bool = False

    def at(self, parameters: Mapping[str, float]) -> EffectInstance:
        """The same effect with other parameters."""
        return EffectInstance(self.effect, self.options, parameters, self.enabled, self.open)


@dataclass(frozen=True)
class Model:
    """The complete description of a twin.

    ``kinds`` holds the fidelity of ``drive`` and ``transmission``, ``constants`` the values by path
    (``machine.motor_inertia``), ``effects`` the instances by name: an effect's first instance is named after its id,
    later ones ``id_2``, ``id_3``…
    """

    name: str
    machine: str
    kinds: Mapping[str, str]
    constants: Mapping[str, ConstantValue]
    effects: Mapping[str, EffectInstance] = field(default_factory=dict)
    motion: str = "rotary"  # or linear: then inertias are masses, torques forces, and motor angles displacements
    lumped: bool = False  # whether there is a single inertia
    units: OwnUnits | None = None  # own units of its values; None: SI
    orders: Mapping[str, float] = field(default_factory=dict)  # by name, cycles per turn of the motor
    other_orders: bool = True  # whether torques of other orders are possible
    choices: Mapping[str, str] = field(default_factory=dict)  # by path, chosen options of its fidelities

    def __post_init__(self) -> None:
        for name in ("kinds", "constants", "effects", "orders", "choices"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    @property
    def active(self) -> dict[str, EffectInstance]:
        """The effects that are switched on, by name."""
        return {name: instance for name, instance in self.effects.items() if instance.enabled}

    @property
    def is_open(self) -> bool:
        """Whether any value of the machine is only the start of a fit."""
        return any(math.isinf(held.tolerance) for held in self.constants.values()) or any(
            instance.open for instance in self.active.values()
        )

    def order_names(self, order: float, within: float = ORDER_ERROR) -> list[str]:
        """Names of an order (cycles per motor turn), or of an order of which it is a multiple: ``4 × slots``.

        Multiples of orders of one or less are not named, since every order is one. The order of the electrical angle
        equals the number of pole pairs.
        """
        exact = [_electrical(name, own) for name, own in self.orders.items() if abs(order - own) <= within]
        multiples = [
            f"{times} × {_electrical(name, own)}"
            for name, own in self.orders.items()
            if own > 1.0 and 1 < (times := round(order / own)) <= _HARMONICS
            if abs(order - times * own) <= within
        ]
        return exact or multiples

    @property
    def pole_pairs(self) -> float | None:
        """Pole pairs of the motor (electrical turns per motor turn), if known, possibly only as an order."""
        held = self.constants.get("machine.pole_pairs")
        return self.orders.get(POLE_PAIRS) if held is None else held.value

    def motor_order(self, name: str) -> float:
        """The order of an effect, in cycles per motor turn."""
        instance = self.effects[name]
        of_output = find_effect(instance.effect, name).where(instance.options) == OUTPUT_TORQUE
        return float(instance.options["order"]) / (self.value("machine.gear_ratio") if of_output else 1.0)

    @property
    def is_direct(self) -> bool:
        """Whether the output turns with the motor."""
        return self.value("machine.gear_ratio") == 1.0

    def value(self, path: str) -> float:
        """The value of the constant at ``path``, in the unit of its table."""
        return self.constants[path].value

    @property
    def turn(self) -> float:
        """Reference of encoder counts: a revolution [rad], or a metre on a linear machine."""
        return 2.0 * math.pi if self.motion == "rotary" else 1.0

    def unit(self, path: str) -> str:
        """The unit of a constant for this machine's motion."""
        return unit_in(CONSTANTS[path].unit, self.motion)

    def parameter_unit(self, effect: str, parameter: str) -> str:
        """The unit of an effect's parameter for this machine's motion; phase angles are always angles."""
        row = next(p for p in find_effect(effect, "effect").parameters if p.name == parameter)
        return row.unit if row.periodic else unit_in(row.unit, self.motion)

    def shown_path(self, path: str) -> str:
        """The path of a constant as shown to users: ``machine.inertia`` if there is a single inertia."""
        return f"machine.{LUMPED}" if self.lumped and path == "machine.motor_inertia" else path

    def fitted_from(self, nominal: Model) -> Model:
        """The same model; the source of each constant that differs from ``nominal`` says that it was fitted."""
        constants = dict(self.constants)
        for path, held in constants.items():
            if held.value != nominal.value(path):
                constants[path] = replace(held, source=f"fitted; {nominal.value(path):g} before")
        return replace(self, constants=constants)

    def with_effect(
        self,
        id: str,
        parameters: Mapping[str, float] | None = None,
        options: Mapping[str, str] | None = None,
        *,
        enabled: bool = True,
    ) -> Model:
        """A model with one more instance of an effect; missing values take the catalogue's defaults."""
        effect = find_effect(id, "effect")
        instance = checked_instance(effect, parameters or {}, options or {}, id, complete=False, motion=self.motion)
        if id in self.effects and not effect.repeatable:
            raise InputError(f"model {self.name}: effect '{id}' is there already; change its parameters instead")
        name, number = id, 2
        while name in self.effects:
            name, number = f"{id}_{number}", number + 1
        return replace(self, effects={**self.effects, name: replace(instance, enabled=enabled)})

    def without_effect(self, name: str) -> Model:
        """A model without an effect: an id removes all its instances, ``id_2`` one."""
        gone = [k for k, v in self.effects.items() if k == name or v.effect == name]
        if name in self.effects and self.effects[name].effect != name:
            gone = [name]
        if not gone:
            self._instance(name)
        return replace(self, effects={k: v for k, v in self.effects.items() if k not in gone})

    def _instance(self, name: str) -> EffectInstance:
        """The effect of that name. Raises InputError if the model has none."""
        if name not in self.effects:
            hint = f"; {nearest(name, tuple(self.effects))}" if self.effects else ", nor any other"
            raise InputError(f"model {self.name}: no effect '{name}'{hint}")
        return self.effects[name]

    def with_value(self, path: str, value: float) -> Model:
        """A model with one value changed: ``effects.NAME.PARAMETER`` or a constant's path.

        Raises InputError with the range if the value is outside it, with the nearest name if the path is unknown.
        """
        if path.startswith("effects."):
            _, name, parameter = [*path.split("."), "", ""][:3]
            instance = self._instance(name)
            effect, parameters = find_effect(instance.effect, path), {**instance.parameters, parameter: value}
            changed = checked_instance(effect, parameters, instance.options, name, complete=True, motion=self.motion)
            changed = replace(changed, enabled=instance.enabled, open=instance.open)
            return replace(self, effects={**self.effects, name: changed})
        constant = CONSTANTS.get(path)
        if constant is None:
            raise InputError(f"model {self.name}: unknown constant '{path}'; {nearest(path, CONSTANTS)}")
        check_range(value, constant.lower, constant.upper, self.unit(path), path)
        before = self.constants.get(path, ConstantValue(value))
        return replace(self, constants={**self.constants, path: replace(before, value=float(value))})

    def with_enabled(self, name: str, enabled: bool) -> Model:
        """A model with one effect switched on or off."""
        return replace(self, effects={**self.effects, name: replace(self._instance(name), enabled=enabled)})

    def with_option(self, name: str, option: str, choice: str) -> Model:
        """A model with one option of an effect set. Raises InputError with the choices if the choice is invalid."""
        held = self._instance(name)
        effect, options = find_effect(held.effect, name), {**held.options, option: choice}
        complete = option != effect.law  # another law may have further parameters, or fewer
        kept = {p.name for p in effect.parameters_with(options)} if effect.allows(option, choice) else ()
        parameters = {name: value for name, value in held.parameters.items() if complete or name in kept}
        changed = checked_instance(effect, parameters, options, name, complete=complete, motion=self.motion)
        return replace(self, effects={**self.effects, name: replace(changed, enabled=held.enabled, open=held.open)})

    def with_setting(self, path: str, value: bool | float | str) -> Model:
        """A model with one setting changed, named as in a running twin's parameters.

        ``effects.NAME.enabled`` (bool), ``effects.NAME.OPTION`` (str), ``effects.NAME.PARAMETER`` or a constant's path
        (float). Raises InputError if it does not exist, or the value is out of range.
        """
        part, _, rest = path.partition(".")
        name, _, word = rest.partition(".")
        if part == "effects" and word == ENABLED:
            return self.with_enabled(name, bool(value))
        if part == "effects" and isinstance(value, str):
            return self.with_option(name, word, value)
        return self.with_value(path, value)  # type: ignore[arg-type]

    def with_settings(self, settings: Mapping[str, bool | float | str]) -> Model:
        """A model with several settings changed, options first, since another law may have parameters of its own.

        A parameter of another law may be set to its default, which changes nothing: a running twin states all of them.
        """
        model = self
        for path, value in sorted(settings.items(), key=lambda item: not isinstance(item[1], str)):
            if not model._is_default_of_another_law(path, value):
                model = model.with_setting(path, value)
        return model

    def _is_default_of_another_law(self, path: str, value: bool | float | str) -> bool:
        part, name, word = [*path.split("."), "", ""][:3]
        instance = self.effects.get(name) if part == "effects" else None
        if instance is None or word in instance.parameters:
            return False
        others = (p for p in find_effect(instance.effect, path).parameters if p.name == word)
        return any(value == p.default for p in others)


def _electrical(name: str, order: float) -> str:
    return f"electrical ({order:g} {POLE_PAIRS})" if name == POLE_PAIRS else name


def nearest(name: str, known: Mapping[str, object] | tuple[str, ...]) -> str:
    """``did you mean 'x'?`` or the list of known names."""
    near = difflib.get_close_matches(name, list(known), n=1)
    return f"did you mean '{near[0]}'?" if near else f"known are {', '.join(known)}"


def check_range(value: object, lower: float, upper: float, unit: str, place: str) -> float:
    """The value as a float. Raises InputError if it is not a finite number within [lower, upper]."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        said = decimal_comma(value) or f"'{value}' is no number; give one in {unit}"
        raise InputError(f"{place}: {said}") from None
    if isinstance(value, bool) or not math.isfinite(number) or not lower <= number <= upper:
        named = "" if unit == "1" else f" {unit}"
        raise InputError(f"{place}: {value}{named} is out of range; give {range_words(lower, upper, unit)}")
    return number


def parameter_range(effect: Effect, parameter: Parameter, motion: str) -> tuple[float, float, str]:
    """(lower, upper, unit) of a parameter of an effect.

    On a linear machine an angle is a length. The bounds that the catalogue gives an angle do not hold for it; those of
    a user's own effect do, since he wrote them for his machine.
    """
    unit = parameter.unit if parameter.periodic else unit_in(parameter.unit, motion)
    if unit == parameter.unit or is_own(effect):
        return parameter.lower, parameter.upper, unit
    lower = -math.inf if parameter.lower < 0.0 else min(parameter.lower, POSITIVE)
    return lower, math.inf, unit


def checked_instance(
    effect: Effect,
    parameters: Mapping[str, object],
    options: Mapping[str, object],
    place: str,
    *,
    complete: bool,
    motion: str = "rotary",
) -> EffectInstance:
    """An instance with checked names, options and ranges. Raises InputError naming ``place`` otherwise.

    ``complete`` requires every parameter; otherwise missing ones take their defaults.
    """
    table = {parameter.name: parameter for parameter in effect.parameters}
    for name in parameters:
        if name not in table:
            raise InputError(f"{place}: effect {effect.id} has no parameter '{name}'; {nearest(str(name), table)}")
    chosen = effect.default_options()
    for name, choice in options.items():
        if name not in effect.options:
            known = nearest(str(name), effect.options) if effect.options else "it has none"
            raise InputError(f"{place}: effect {effect.id} has no option '{name}'; {known}")
        if not effect.allows(name, str(choice)):
            raise InputError(f"{place}: option {name} is '{choice}'; give one of {effect.choices_in_words(name)}")
        chosen[name] = str(choice)
    own = {parameter.name: parameter for parameter in effect.parameters_with(chosen)}
    elsewhere = next((table[name] for name in parameters if name not in own), None)
    if elsewhere is not None:
        raise InputError(
            f"{place}: effect {effect.id} has no parameter '{elsewhere.name}' with {effect.law}: {chosen[effect.law]}; "
            f"choose {effect.law}: {elsewhere.choice}, or leave it out"
        )
    values = {}
    for name, parameter in own.items():
        if name not in parameters and complete:
            raise InputError(
                f"{place}: parameter '{name}' [{parameter.unit}] of effect {effect.id} is missing; give it"
            )
        given = parameters.get(name, parameter.default)
        lower, upper, unit = parameter_range(effect, parameter, motion)
        values[name] = check_range(given, lower, upper, unit, f"{place}.{name}")
    return EffectInstance(effect.id, MappingProxyType(chosen), MappingProxyType(values))
