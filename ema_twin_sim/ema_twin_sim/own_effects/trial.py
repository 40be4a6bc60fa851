"""A trial of a user's effect: compiled and called over its options, bounds and a few operating points.

Errors that would stop a twin during a run (an unknown name, a division by zero, a parameter that is not in the table)
are found here, and reported with file, line and remedy.
"""

from __future__ import annotations

import inspect
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ema_bench_replay.errors import InputError

from ..effects.effect import DRY_LEVEL, OUTPUT_TORQUE, TORQUE, VISCOUS_COEFFICIENT, Effect, Options
from ..listing import number_of
from ..model.model import nearest
from ..plant.layout import PLANT
from ..plant.operating_point import PARAMETER_SLOTS, OperatingPoint, compiled_effect
from ..plant.switching.layout import WINDING
from .refusal import line_of, words

_COMPILABLE = "act may use numbers, at, p, math and numpy, and helpers under @numba.njit(error_model='numpy')"
_LAYOUTS = {"settle": "layout.py", "settle_winding": "switching/layout.py"}
_PLACES = {
    TORQUE: "TORQUE",
    DRY_LEVEL: "DRY_LEVEL",
    OUTPUT_TORQUE: "OUTPUT_TORQUE",
    VISCOUS_COEFFICIENT: "VISCOUS_COEFFICIENT",
}


def _point(time: float, speed: float, dry_level: float) -> OperatingPoint:
    """Operating point of a machine of the bench's size at a time [s] and motor speed [rad/s]."""
    return OperatingPoint(
        time=time,
        motor_angle=speed * time,
        electrical_angle=4.0 * speed * time,
        motor_speed=speed,
        output_angle=speed * time / 124.0,
        output_travel=speed * time / 124.0,
        output_speed=speed / 124.0,
        acceleration=2.0 * speed,
        current=0.1 * speed,
        motor_torque=0.15 * speed,
        transmitted_torque=0.05 * speed,
        dry_level=dry_level,
        viscous_coefficient=0.5 * dry_level,
    )


POINTS = (_point(0.0, 0.0, 0.0), _point(5.0, 0.01, 0.05), _point(1.0, -6.2, 0.05), _point(100.0, 150.0, 0.05))
"""Operating points at which a user's effect is tried."""


def try_out(file: Path, effect: Effect) -> None:
    """Raise InputError unless the effect is finite in every trial."""
    for options in choices(effect):
        try:
            place = effect.where(options)
            numeric = () if effect.option_value is None else (float(effect.option_value(options)),)
        except Exception as error:
            what = f"place or option_value fails under {_told(options)}: {words(error)}"
            raise InputError(f"{file}: {line_of(error, file)}{what}; let it take every option's every choice") from None
        for value in numeric:
            if not math.isfinite(value):
                raise InputError(f"{file}: EFFECT.option_value: is {value} under {_told(options)}; make it finite")
        if not isinstance(place, int) or place not in _PLACES:
            raise InputError(f"{file}: EFFECT.place: {place!r} is none; give one of {', '.join(_PLACES.values())}")
        if effect.settle is not None:
            _try_settle(file, effect, "settle", np.ones(1, PLANT), options)
        if effect.settle_winding is not None:
            _try_settle(file, effect, "settle_winding", np.ones(1, WINDING), options)
        if effect.act is not None:
            _try_act(file, effect, effect.act, options, numeric)


def choices(effect: Effect) -> Iterator[dict[str, str]]:
    """Every combination of an effect's options."""
    for choice in itertools.product(*effect.options.values()):
        yield dict(zip(effect.options, choice, strict=True))


def _settings(effect: Effect) -> Iterator[dict[str, float]]:
    """The defaults, and each parameter at its finite bounds."""
    defaults = effect.default_parameters()
    yield defaults
    for p in effect.parameters:
        yield from ({**defaults, p.name: bound} for bound in (p.lower, p.upper) if math.isfinite(bound))


def _try_settle(file: Path, effect: Effect, way: str, constants: np.ndarray, options: Options) -> None:
    """Try the function with that name on constants (1,) that are all one."""
    held = {p.name for p in effect.parameters_with(options)}
    for parameters in ({k: v for k, v in setting.items() if k in held} for setting in _settings(effect)):
        settled = constants.copy()
        try:
            getattr(effect, way)(settled[0], parameters, options)
        except Exception as error:
            what = f"{way} fails with {_told({**parameters, **options})}: {words(error)}"
            remedy = f"it may change the constants in ema_twin_sim/plant/{_LAYOUTS[way]}"
            raise InputError(f"{file}: {line_of(error, file)}{what}; {remedy}") from None
        for name in settled.dtype.names or ():
            if not np.isfinite(settled[name]).all():
                what = f"{way} makes {name} {settled[name][0]} with {_told({**parameters, **options})}"
                raise InputError(f"{file}: {what}; keep it finite for all values within bounds")


def _try_act(
    file: Path, effect: Effect, act: Callable[..., float], options: Options, numeric: tuple[float, ...]
) -> None:
    compiled = _compiled(file, act, (*effect.default_parameters().values(), *numeric))
    for parameters, at in itertools.product(_settings(effect), POINTS):
        values = (*parameters.values(), *numeric)
        where = f"at motor_speed {at.motor_speed:g}, time {at.time:g}, with {_told({**parameters, **options})}"
        try:
            value = compiled(at, values + (0.0,) * (PARAMETER_SLOTS - len(values)))
        except Exception as error:
            place = line_of(error, file) or _start(act)
            remedy = "let it return a number for all values within bounds"
            raise InputError(f"{file}: {place}act raises {words(error)} {where}; {remedy}") from None
        if not math.isfinite(value):
            remedy = "keep it finite for all values within bounds (a lower bound above 0, a case for standstill)"
            raise InputError(f"{file}: {_start(act)}act gives {value} {where}; {remedy}")
    unknown = POINTS[1]._replace(electrical_angle=math.nan)
    values = (*effect.default_parameters().values(), *numeric)
    if not effect.electrical and math.isnan(compiled(unknown, values + (0.0,) * (PARAMETER_SLOTS - len(values)))):
        what = "act takes at.electrical_angle, which is known of motors of known pole pairs only"
        raise InputError(f"{file}: {_start(act)}{what}; say electrical=True in EFFECT")


def _compiled(file: Path, act: Callable[..., float], values: tuple[float, ...]) -> Callable[..., float]:
    """``act`` compiled. Raises InputError with the line that cannot be compiled."""
    try:
        inspect.signature(act).bind(None, None)
    except (TypeError, ValueError):
        raise InputError(f"{file}: {_start(act)}act does not take two arguments; define act(at, p)") from None
    plain: Exception | None = None
    for at in POINTS:
        try:
            act(at, _Table(values))
        except _NotInTable as missing:
            held = number_of(len(values), "parameter")
            what = f"act reads p[{missing}], but the table has {held}, numeric options included"
            raise InputError(f"{file}: {line_of(missing, file)}{what}; add a Parameter, or count from p[0]") from None
        except AttributeError as error:
            if error.obj is at:
                what = f"at has no '{error.name}'; {nearest(str(error.name), at._fields)}"
                raise InputError(f"{file}: {line_of(error, file)}{what}") from None
            plain = plain or error
        except (NameError, TypeError) as error:
            plain = plain or error
        except Exception:
            continue  # plain Python is stricter (1 / 0): the compiled function decides, below
    try:
        return compiled_effect(act, on_disk=False)
    except Exception as error:
        told = plain or error  # Python's message for the same mistake is clearer, and has a line
        place = line_of(told, file) or _start(act)
        raise InputError(f"{file}: {place}act does not compile: {words(told)}; {_COMPILABLE}") from None


def _start(act: Callable[..., float]) -> str:
    code = getattr(act, "__code__", None)
    return f"line {code.co_firstlineno}: " if code else ""


def _told(values: Mapping[str, object]) -> str:
    return ", ".join(f"{k} {v:g}" if isinstance(v, float) else f"{k} {v}" for k, v in values.items()) or "no options"


class _NotInTable(Exception):
    """A parameter outside the table is read; compiled code would silently read a zero."""


class _Table(tuple[float, ...]):
    """The parameters of the table only."""

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, int) and not 0 <= index < len(self):
            raise _NotInTable(index)
        return super().__getitem__(index)
