"""The free parameters of a fit, each with bounds, a finite-difference step and prior knowledge."""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.errors import InputError

from ..criteria import ANY_SIZE, NEGLIGIBLE, PART, SEARCHED_UP_TO, TOLERANCE, UNSEEN_SPREAD
from ..effects import Effect, Parameter, catalogue
from ..identification.hypothesis import COMPLIANT_EFFECTS, INERTIAS
from ..identification.search_limits import Reached, search_limits
from ..identification.start_values import WIDE
from ..listing import listed
from ..model import Model
from ..model.constants import CONSTANTS
from ..model.own_units import shown, table_in, told
from ..model.roles import DRY_FRICTION, FRICTION

WEAK_ANGLE = 10.0  # rad, more than one and a half turns: any angle
STEP = 2e-3  # finite-difference step, relative to a parameter's typical size
STRUCTURAL_STEP = 0.01  # for a width, a stiffness, a speed, whose action has kinks
SPAN = 0.1  # share of the bounds used as typical size if a parameter may be anywhere in them
OFF_BOUND = 0.2  # of the distance to its typical value, for a start on a bound


@dataclass(frozen=True)
class FreeParameter:
    """One free parameter. Several numbers of a model may be tied to it, with ``shares`` as factors of the first.

    The solver uses the value, or its logarithm if ``log``; ``step`` is the finite difference of the solver's variable.
    ``prior`` is mean and standard deviation; ``known`` is whether it is knowledge of the machine and not only a guard
    against divergence. ``scale`` is the typical size.
    """

    path: str
    paths: tuple[str, ...]
    shares: tuple[float, ...]
    unit: str
    lower: float
    upper: float
    scale: float
    step: float
    prior: tuple[float, float]
    known: bool = False
    log: bool = False
    periodic: bool = False

    def to_solver(self, value: float) -> float:
        """The solver's variable for a value."""
        return math.log(max(value, 1e-300)) if self.log else value

    @property
    def solved_bounds(self) -> tuple[float, float]:
        """(lower, upper) of the solver's variable; a logarithm stays within the floating-point range."""
        if self.log:
            return self.to_solver(self.lower), self.to_solver(min(self.upper, sys.float_info.max))
        return self.lower, self.upper

    def from_solver(self, solved: float) -> float:
        """The value for a solver's variable."""
        return math.exp(solved) if self.log else solved

    def slope(self, value: float) -> float:
        """Change of the value per change of the solver's variable."""
        return value if self.log else 1.0

    @property
    def solver_prior(self) -> tuple[float, float]:
        """Mean and standard deviation of the prior on the solver's variable."""
        mean, std = self.prior
        return (self.to_solver(mean), std / mean) if self.log else self.prior


@dataclass(frozen=True, eq=False)
class FreeParameters:
    """A model and its free parameters. ``notes`` are sentences on what was tied, held or moved beforehand."""

    model: Model
    numbers: tuple[FreeParameter, ...]
    start: np.ndarray  # (k,)
    notes: tuple[str, ...]

    def at(self, values: np.ndarray) -> Model:
        """The model with these values (k,)."""
        constants = dict(self.model.constants)
        changed: dict[str, dict[str, float]] = {}
        for number, value in zip(self.numbers, values, strict=True):
            for path, share in zip(number.paths, number.shares, strict=True):
                part, name, parameter = split(path)
                if part == "effects":
                    changed.setdefault(name, {})[parameter] = float(value) * share
                else:
                    constants[path] = replace(constants[path], value=float(value) * share)
        effects = dict(self.model.effects)
        for name, parameters in changed.items():
            effects[name] = replace(effects[name], parameters={**effects[name].parameters, **parameters})
        return replace(self.model, constants=constants, effects=effects)

    def index(self, path: str) -> int | None:
        """Index of the parameter that changes this path; None if it is held."""
        return next((k for k, number in enumerate(self.numbers) if path in number.paths), None)

    def within(self, of: Reached) -> FreeParameters:
        """Limit unbounded effect parameters to what the recordings reach, or to far beyond their start."""
        numbers = list(self.numbers)
        for k, (number, start) in enumerate(zip(self.numbers, self.start, strict=True)):
            part, name, _ = split(number.path)
            if part != "effects" or number.periodic:
                continue
            lower, upper = search_limits(_table(self.model, name), _parameter_of(self.model, number.path), of)
            most = SEARCHED_UP_TO * abs(float(start))
            if math.isinf(number.upper):
                if math.isinf(upper):  # a stiffness: far beyond its start it is practically rigid
                    upper = ANY_SIZE * number.scale
                numbers[k] = replace(
                    number,
                    lower=min(lower, float(start)) if start > 0.0 else min(lower, -most),
                    upper=max(upper, most),
                )
        return replace(self, numbers=tuple(numbers))

    def with_priors_loose(self, which: Sequence[int]) -> FreeParameters:
        """The same with the priors of these parameters released."""
        numbers = [
            replace(n, prior=(n.prior[0], _weak(n.scale, n.periodic)), known=False) if k in which else n
            for k, n in enumerate(self.numbers)
        ]
        return replace(self, numbers=tuple(numbers))


def split(path: str) -> tuple[str, str, str]:
    """(``effects``, instance, parameter) or (part, name, "")."""
    part, name, parameter = [*path.split("."), "", ""][:3]
    return part, name, parameter


def all_paths(model: Model) -> tuple[str, ...]:
    """The paths of everything in a model that could be fitted."""
    effects = (
        f"effects.{name}.{parameter.name}"
        for name, instance in model.effects.items()
        if instance.enabled
        for parameter in catalogue()[instance.effect].parameters_with(instance.options)
    )
    return (*effects, *model.constants)


def choose_numbers(model: Model, free: Sequence[str], fix: Sequence[str]) -> FreeParameters:
    """Choose the free parameters: those of effects, the inertias and what ``free`` names, without ``fix``.

    Both name paths or prefixes of paths (``effects.backlash``). Parameters that act only at rest are held unless named,
    because a fit leaves standstill out. Raises InputError if a path is unknown or exact.
    """
    known = all_paths(model)
    freed, fixed = (_named(model, known, given, option) for given, option in ((free, "--free"), (fix, "--fix")))
    for path in freed:
        if path in fixed:
            raise InputError(f"{path}: is named by --free and by --fix; leave one out")
    parted = model.kinds["transmission"] == "two_inertia" or any(
        instance.enabled and instance.effect in COMPLIANT_EFFECTS for instance in model.effects.values()
    )
    effects = [path for path in known if path.startswith("effects.") and path not in fixed]
    held = [path for path in effects if _parameter_of(model, path).at_rest and path not in freed]
    by_default = [path for path in effects if path not in held and path not in freed]
    notes = [
        f"{name} is held: it shows at standstill only, which a fit leaves out"
        for name in dict.fromkeys(split(path)[2] for path in held)
    ]
    numbers = []
    for group in _tied(model, by_default, parted):
        numbers.append(_parameter(model, group, parted, asked=False))
        # not worth a note if one part is below 2 % of the other
        if len(group) > 1 and min(_value(model, path) for path in group[1:]) > NEGLIGIBLE * _value(model, group[0]):
            names = " and ".join(split(path)[1] for path in group)
            notes.append(f"{split(group[0])[2]} of {names}: only the sum shows, both were scaled by one factor")
    numbers += [_parameter(model, (path,), parted, asked=True) for path in effects if path in freed]
    numbers += [_constant(model, group) for group in _inertias(model, (*fixed, *freed), parted)]
    numbers += [_constant(model, (path,)) for path in freed if not path.startswith("effects.")]
    if not numbers:
        raise InputError(f"model {model.name}: nothing is free to be fitted; name fewer paths with --fix")
    values = np.array([_value(model, number.path) for number in numbers])
    for k, number in enumerate(numbers):
        away = next((bound for bound in (number.lower, number.upper) if values[k] == bound), None)
        if away is not None:
            step_off = number.scale if away == number.lower else -number.scale
            values[k] = min(max(away + OFF_BOUND * step_off, number.lower), number.upper)
            began, unit = shown(model, float(values[k]), number.unit)
            named = f"{model.shown_path(number.path)} stood on its bound, where a fit sees no way off"
            notes.append(f"{named}: it started at {began:g}{'' if unit == '1' else f' {unit}'}")
    return FreeParameters(model, tuple(numbers), values, tuple(notes))


def not_by_encoders(model: Model, free: Sequence[str]) -> list[str]:
    """Paths that two encoders without torque data cannot show (all torques), except those in ``free``."""
    held = {instance.effect for instance in model.active.values()}
    winding_up = {DRY_FRICTION} if held & {*COMPLIANT_EFFECTS} else set()  # of the output, by which it comes to rest
    hidden = [
        f"effects.{name}"
        for name, instance in model.effects.items()
        if instance.enabled
        and catalogue()[instance.effect].depends_on != "encoders"
        and not (instance.effect in winding_up and instance.options.get("side") == "output")
    ]
    return [
        path for path in (*hidden, *INERTIAS) if not any(text == path or text.startswith(f"{path}.") for text in free)
    ]


def _parameter_of(model: Model, path: str) -> Parameter:
    """The catalogue entry of the parameter that a path names."""
    _, name, parameter = split(path)
    return next(p for p in _table(model, name).parameters if p.name == parameter)


def _table(model: Model, name: str) -> Effect:
    """The effect of an instance, the numbers of its table in the units of the model."""
    return table_in(catalogue()[model.effects[name].effect], model.units)


def waves(freedom: FreeParameters) -> list[tuple[int, int]]:
    """Indices of amplitude and phase of waves: effects that have one of each and grow from zero."""
    found = []
    for name, instance in freedom.model.effects.items():
        effect = catalogue()[instance.effect]
        angle = effect.wave_angle
        if angle is not None:
            places = [freedom.index(f"effects.{name}.{p.name}") for p in (effect.parameters[0], angle)]
            if places[0] is not None and places[1] is not None:
                found.append((places[0], places[1]))
    return found


def _nearest(text: str, known: Sequence[str]) -> str:
    """``did you mean 'x'?``, or what the named part has, or the parts: all paths would be too many for one line."""
    if near := difflib.get_close_matches(text, known, n=1):
        return f"did you mean '{near[0]}'?"
    part = text.partition(".")[0]
    inside = [path for path in known if path.partition(".")[0] == part]
    if inside:
        return f"of {part} it has {listed(path.partition('.')[2] for path in inside)}"
    return f"its numbers begin with {listed(dict.fromkeys(path.partition('.')[0] for path in known), 'or')}"


def _named(model: Model, known: Sequence[str], given: Sequence[str], option: str) -> list[str]:
    found: dict[str, None] = {}
    names = {model.shown_path(path): path for path in model.constants}
    shown_names = [model.shown_path(path) for path in known]
    for text in given:
        text = names.get(text, text)
        here = [path for path in known if path == text or path.startswith(f"{text}.")]
        if not here or text in ("effects", *(c.part for c in CONSTANTS.values())):
            raise InputError(f"{option} {text}: model {model.name} has no such number; {_nearest(text, shown_names)}")
        found.update(dict.fromkeys(here))
    return list(found)


def _tied(model: Model, paths: Sequence[str], parted: bool) -> list[tuple[str, ...]]:
    """Group paths that are scaled together: friction of both sides, if the sides cannot be separated."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for path in paths:
        _, name, parameter = split(path)
        instance = model.effects[name]
        alone = instance.effect not in FRICTION or _doubled(model, name) or _value(model, path) <= 0.0
        apart = parted and instance.effect == DRY_FRICTION and parameter == "torque"
        groups.setdefault((path,) if alone or apart else (instance.effect, parameter), []).append(path)
    return [tuple(group) for group in groups.values()]


def _doubled(model: Model, name: str) -> bool:
    """Whether the same effect exists again on the same side: then the split between them is arbitrary."""
    one = model.effects[name]
    alike = [i for i in model.effects.values() if i.enabled and (i.effect, i.options) == (one.effect, one.options)]
    return len(alike) > 1


def _inertias(model: Model, named: Sequence[str], parted: bool) -> list[tuple[str, ...]]:
    """The inertias that are free by default, grouped by what is scaled together."""
    free = [p for p in INERTIAS if p not in named and model.value(p) > 0.0 and model.constants[p].tolerance > 0.0]
    motor, output = (tuple(p for p in free if (p == INERTIAS[2]) == is_output) for is_output in (False, True))
    groups = [motor, output] if parted else [motor + output]
    return [group for group in groups if group]


def _value(model: Model, path: str) -> float:
    part, name, parameter = split(path)
    return model.effects[name].parameters[parameter] if part == "effects" else model.value(path)


def _weak(scale: float, periodic: bool) -> float:
    return WEAK_ANGLE if periodic else UNSEEN_SPREAD * scale


def _parameter(model: Model, paths: tuple[str, ...], parted: bool, *, asked: bool) -> FreeParameter:
    _, name, _ = split(paths[0])
    instance = model.effects[name]
    effect = _table(model, name)
    p = _parameter_of(model, paths[0])
    value = _value(model, paths[0])
    neutral = p.neutral if p is effect.parameters[0] and p.neutral is not None else 0.0
    scale = max(abs(value - neutral), abs(p.default - neutral))
    if p.periodic or scale == 0.0:  # an angle; or a position, which has no size of its own
        scale = 1.0 if p.periodic or math.isinf(p.upper - p.lower) else SPAN * (p.upper - p.lower)
    log = p.lower > 0.0 and p.upper >= WIDE * p.lower
    lower, upper = p.lower, p.upper
    if p.periodic:
        lower, upper = -math.inf, math.inf
    size = p is effect.parameters[0]
    told = value > 0.0 and not instance.open and not _doubled(model, name)
    known = size and not asked and instance.effect in FRICTION and told
    side = parted and instance.effect == DRY_FRICTION and instance.options["side"] == "output"
    prior = (PART if side else TOLERANCE) * value if known else _weak(scale, p.periodic)
    return FreeParameter(
        paths[0],
        paths,
        tuple(_value(model, path) / value if len(paths) > 1 else 1.0 for path in paths),
        p.unit,
        lower,
        upper,
        scale,
        STRUCTURAL_STEP * (1.0 if log else scale) if p.neutral is None or log else STEP * scale,
        (value, prior),
        known=known,
        log=log,
        periodic=p.periodic,
    )


def _constant(model: Model, paths: tuple[str, ...]) -> FreeParameter:
    constant = CONSTANTS[paths[0]]
    held = model.constants[paths[0]]
    tolerance = max(model.constants[path].tolerance for path in paths)
    if tolerance == 0.0:
        raise InputError(
            f"--free {paths[0]}: its tolerance in model {model.name} is 0, so it is exact; give it a tolerance there"
        )
    if held.value == 0.0:
        raise InputError(
            f"--free {paths[0]}: is 0 in model {model.name}, and no factor moves it; give it a value there"
        )
    least, most = (told(model, bound, constant.unit) for bound in (constant.lower, constant.upper))
    log = constant.lower > 0.0
    return FreeParameter(
        paths[0],
        paths,
        tuple(model.value(path) / held.value for path in paths),
        constant.unit,
        max(least, abs(held.value) / ANY_SIZE) if log else max(least, -ANY_SIZE * abs(held.value)),
        min(most, ANY_SIZE * abs(held.value)),
        abs(held.value),
        STEP * (1.0 if log else abs(held.value)),
        (held.value, min(tolerance, SEARCHED_UP_TO) * abs(held.value)),
        known=math.isfinite(tolerance),
        log=log,
    )
