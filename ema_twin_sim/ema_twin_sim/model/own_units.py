"""A machine's own units of time, torque and current, and the drum radius of a linear machine.

Mechanics is covariant. With time, torque and current scaled, a recording of one machine is a recording of another,
whose constants scale with their units. The prior knowledge of a search (which speed is standstill, how wide is a
kernel, how large may an effect be) comes from one machine, the reference bench. So recordings and model are converted
to units in which the machine has the size of the reference bench, and results are converted back to SI.

A linear machine is treated as a rotary one whose carriage runs round a drum of some radius: x = r θ, F = T / r.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from ema_bench_replay.long_columns import by_pieces, divided
from ema_bench_replay.recording import MOTION, Recording
from ema_bench_replay.units import signal_unit, unit_in

from ..effects import Effect, Parameter, find_effect
from ..effects.catalogue import is_own
from .constants import CONSTANTS
from .model import Model

_POWERS = {
    "N m": (-1, 0, 1, 0),
    "kg m^2": (-2, 2, 1, 0),
    "rad": (1, 0, 0, 0),
    "rev": (1, 0, 0, 0),
    "s": (0, 1, 0, 0),
    "Hz": (0, -1, 0, 0),
    "A": (0, 0, 0, 1),
    "V": (0, -1, 1, -1),
    "ohm": (0, -1, 1, -2),
    "H": (0, 0, 1, -2),
}
"""For each part of a rotary unit, the powers of radius, time, torque and current that convert own to native values.
Volts follow from power: V A = N m / s. Other parts are not scaled."""
_UNSCALED = ("1", "K", "count")
ORDER_UNIT = "1/rev"  # of a linear machine, in cycles per metre
ORDER_DIGITS = 12  # of an order in own units, more than any recording tells
_PART = re.compile(r"(/)|(N m|kg m\^2|[^\s/^]+)(?:\^(\d+))?")


@cache
def _powers(unit: str) -> tuple[int, ...]:
    """The powers of a unit from those of its parts: for ``N m s^2/rad^2``, N m plus twice s minus twice rad."""
    total: tuple[int, ...] = (0, 0, 0, 0)
    sign = 1
    for slash, part, times in _PART.findall(unit):
        if slash:
            sign = -1
        else:
            of_part = _POWERS.get(part, (0, 0, 0, 0))
            total = tuple(a + sign * int(times or 1) * b for a, b in zip(total, of_part, strict=True))
    return total


def is_scalable(unit: str) -> bool:
    """Whether a rotary unit is made of known parts with whole powers: only then can its values be converted.

    A torque has no power of its own, since ``N m^2`` may mean either.
    """
    found = _PART.findall(unit)
    known = all(slash or part in _POWERS or part in _UNSCALED for slash, part, _ in found)
    unclear = any(part == "N m" and power for _, part, power in found) or unit.rstrip().endswith("/")
    return known and not unclear and not _PART.sub("", unit).strip()


@dataclass(frozen=True)
class OwnUnits:
    """Sizes of the own units in s, N m and A, and the drum radius [m] of a linear machine (otherwise None)."""

    time: float = 1.0
    torque: float = 1.0
    current: float = 1.0
    radius: float | None = None

    def factor(self, unit: str) -> float:
        """Factor that converts a value in own units (rotary unit) to the machine's native unit."""
        turn = 2.0 * math.pi if unit == "1/rev" and self.radius is not None else 1.0  # a carriage's counts are per m
        sizes = (self.radius or 1.0, self.time, self.torque, self.current)
        return math.prod(size**power for size, power in zip(sizes, _powers(unit), strict=True)) / turn


@cache
def table_in(effect: Effect, units: OwnUnits | None) -> Effect:
    """An effect, the numbers of its table in the units of a model.

    Those of the catalogue are of a machine of the reference bench's size, as every machine is in own units. A user
    writes those of his own effect for his machine, whose ``rad`` are metres if it is linear: they are converted to own
    units, as the model's values are. An angle of a wave stays as it is.
    """
    if units is None or not is_own(effect):
        return effect
    return replace(effect, parameters=tuple(_in_units(parameter, units) for parameter in effect.parameters))


def _in_units(parameter: Parameter, units: OwnUnits) -> Parameter:
    factor = 1.0 if parameter.periodic else units.factor(parameter.unit)
    return replace(
        parameter,
        default=parameter.default / factor,
        lower=parameter.lower / factor,
        upper=parameter.upper / factor,
        starts=tuple(start / factor for start in parameter.starts),
        neutral=None if parameter.neutral is None else parameter.neutral / factor,
    )


def model_in(model: Model, units: OwnUnits) -> Model:
    """A native model converted to own units, which it stores."""
    return replace(_scaled(model, units, -1), motion="rotary", units=units)


def native(model: Model) -> Model:
    """A model in own units converted to native units; any other model unchanged."""
    if model.units is None:
        return model
    return replace(_scaled(model, model.units, 1), motion=shown_motion(model), units=None)


def in_si(model: Model) -> Model:
    """A model in own units converted to SI; a linear machine stays a rotary drum, as in the comparison of twins."""
    if model.units is None:
        return model
    in_native = native(model)
    return in_native if model.units.radius is None else model_in(in_native, OwnUnits(radius=model.units.radius))


def native_as_given(model: Model, given: Model) -> Model:
    """A model in own units converted to native units; values unchanged from the ``given`` native model stay exact."""
    if model.units is None:
        return model
    back, began = native(model), model_in(given, model.units)
    constants = {
        path: given.constants[path] if held == began.constants[path] else back.constants[path]
        for path, held in model.constants.items()
    }
    effects = {
        name: given.effects[name] if instance == began.effects.get(name) else back.effects[name]
        for name, instance in model.effects.items()
    }
    return replace(back, constants=constants, effects=effects)


def recording_in(recording: Recording, units: OwnUnits) -> Recording:
    """A native recording converted to own units."""
    if units == OwnUnits():
        return recording
    way = units.factor("rad")
    metadata = dict(recording.metadata)
    if units.radius is not None:
        metadata[MOTION] = "rotary"
    return replace(
        recording,
        stamps=by_pieces(lambda stamps: np.rint(stamps / units.time).astype(np.int64), recording.stamps),
        signals={name: divided(values, units.factor(signal_unit(name))) for name, values in recording.signals.items()},
        motor_angle_origin=recording.motor_angle_origin / way,
        output_angle_origin=recording.output_angle_origin / way,
        metadata=metadata,
    )


def is_linear(model: Model) -> bool:
    """Whether a model in own or native units is of a machine that moves along a line."""
    return shown_motion(model) == "linear"


def shown_motion(model: Model) -> str:
    """The motion of a model's machine: a drum stands for a linear one."""
    if model.units is None:
        return model.motion
    return "rotary" if model.units.radius is None else "linear"


def shown(model: Model, value: float, unit: str) -> tuple[float, str]:
    """A value of a model and its (rotary) unit converted for display: SI, linear units for a carriage."""
    factor = 1.0 if model.units is None else model.units.factor(unit)
    return value * factor, unit_in(unit, shown_motion(model))


def told(model: Model, value: float, unit: str) -> float:
    """A value in SI (rotary unit) converted to a model's own units."""
    return value if model.units is None else value / model.units.factor(unit)


def shown_entry(model: Model, value: float, std: float | None, unit: str, *, angle: bool = False) -> dict[str, Any]:
    """``{value, std, unit}`` for display; ``unit`` is the rotary one; an ``angle`` keeps its unit on any machine."""
    if angle:
        return {"value": value, "std": std, "unit": unit}
    own, written = shown(model, value, unit)
    return {"value": own, "std": None if std is None else shown(model, std, unit)[0], "unit": written}


def _scaled(model: Model, units: OwnUnits, sign: int) -> Model:
    constants = {
        path: replace(held, value=held.value * units.factor(CONSTANTS[path].unit) ** sign)
        for path, held in model.constants.items()
    }
    effects = {}
    per_turn = units.factor(ORDER_UNIT) ** sign
    for name, instance in model.effects.items():
        rows = find_effect(instance.effect, name).parameters
        factors = {p.name: 1.0 if p.periodic else units.factor(p.unit) for p in rows}
        parameters = {k: v * factors[k] ** sign for k, v in instance.parameters.items()}
        options = _with_order_times(per_turn, instance.options, shown=sign > 0)
        effects[name] = replace(instance, parameters=parameters, options=options)
    orders = {name: order * per_turn for name, order in model.orders.items()}
    return replace(model, constants=constants, effects=effects, orders=orders)


def _with_order_times(factor: float, options: Mapping[str, str], *, shown: bool) -> dict[str, str]:
    """Options of an effect, its order if it has one multiplied by ``factor``; to be ``shown``, as precise as it was."""
    order = options.get("order")
    if order is None or factor == 1.0:
        return dict(options)
    digits = min(1 + len(re.sub(r"\D", "", order).lstrip("0")), ORDER_DIGITS) if shown else ORDER_DIGITS
    return {**options, "order": f"{float(order) * factor:.{digits}g}"}


def shown_options(model: Model, options: Mapping[str, str]) -> dict[str, str]:
    """Options of an effect of a model in own units, as in the machine's native model."""
    factor = 1.0 if model.units is None else model.units.factor(ORDER_UNIT)
    return _with_order_times(factor, options, shown=True)
