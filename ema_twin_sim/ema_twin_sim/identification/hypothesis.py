"""A hypothesis: a model and its free parameters, each with bounds, a scale and an optional prior."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..criteria import ANY_SIZE, SEARCHED_BEYOND_STARTS, STIFFEST, TOLERANCE
from ..effects import Parameter, catalogue
from ..measured.scales import INERTIAS
from ..model import ConstantValue, EffectInstance, Model
from ..model.model_file import ABSENT
from ..model.own_units import table_in
from ..model.roles import COMPLIANT_EFFECTS, DRY_FRICTION, PLAY, SPRING, TORQUE_FACTOR
from ..plant.driven_output import RESOLVED
from ..simulation.assembly import assemble
from ..simulation.fidelity import own_step
from ..simulation.longest_step import longest_step

DRY_SCALE = f"scale.{DRY_FRICTION}"
LAG = "lag"
EXACT = 1e-4  # relative: a tolerance of zero
SIDED = ("scale.output_", "contact.")  # prefixes of paths that only show if the encoders differ
SHARES = ("scale.inertia", "scale.output_inertia", DRY_SCALE, "scale.output_coulomb")


@dataclass(frozen=True)
class Free:
    """One free parameter.

    ``path`` is one of: ``effects.NAME.PARAMETER``; ``scale.GROUP`` (factor on the model's value); ``quarter.EFFECT`` (a
    copy of a wave of the model, a quarter of a period ahead, times this factor); ``contact.PARAMETER`` of the teeth;
    ``lag``; ``basis.NAME.COLUMN``.
    """

    path: str
    lower: float
    upper: float
    step: float  # for finite differences
    prior: tuple[float, float] | None = None  # mean, standard deviation


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A start model with added effects, and its free parameters at ``values`` (k,)."""

    base: Model  # the model that was given
    added: Mapping[str, EffectInstance]
    free: tuple[Free, ...]
    values: np.ndarray

    @property
    def effects(self) -> tuple[str, ...]:
        """The ids of the added effects."""
        return tuple(instance.effect for instance in self.added.values())

    @property
    def held(self) -> frozenset[str]:
        """The ids of all active effects: the model's own and the added ones."""
        return frozenset(self._ids)

    def count(self, effect: str) -> int:
        """How many of the active effects, the model's own and the added ones, have this id."""
        return self._ids.count(effect)

    @property
    def _ids(self) -> list[str]:
        return [instance.effect for instance in (*self.base.active.values(), *self.added.values())]

    def at(self, values: np.ndarray) -> Hypothesis:
        """The same hypothesis at other values."""
        return replace(self, values=np.asarray(values, float))

    @property
    def by_path(self) -> dict[str, float]:
        """The free parameters by path."""
        return {free.path: float(value) for free, value in zip(self.free, self.values, strict=True)}

    def put(self, values: Mapping[str, float]) -> Hypothesis:
        """The same hypothesis with the free parameters named in ``values`` (by path) changed."""
        return self.at(np.array([values.get(path, value) for path, value in self.by_path.items()]))

    def holding(self, values: Mapping[str, float]) -> Hypothesis:
        """The same hypothesis with some parameters (by path) held at these values."""
        free = tuple(
            replace(one, lower=values[one.path], upper=values[one.path]) if one.path in values else one
            for one in self.free
        )
        return replace(self, free=free).put(values)

    def nominal(self) -> dict[str, float]:
        """By path: the values that the model file gives, within a tolerance, to free parameters."""
        return {free.path: free.prior[0] for free in self.free if free.prior is not None}

    def parameter_of(self, path: str) -> Parameter | None:
        """Catalogue entry of the free parameter at a ``path``; None if it is not an added effect's."""
        kind, _, rest = path.partition(".")
        name, _, parameter = rest.partition(".")
        if kind != "effects" or name not in self.added:
            return None
        effect = table_in(catalogue()[self.added[name].effect], self.base.units)
        return next(p for p in effect.parameters if p.name == parameter)

    def lag(self) -> float:
        """Time [s] by which the current leads the motion."""
        return self.by_path.get(LAG, 0.0)

    def instance(self, name: str) -> EffectInstance:
        """An added effect at the current values."""
        held = self.added[name]
        parameters = dict(held.parameters)
        start = f"effects.{name}."
        for free, value in zip(self.free, self.values, strict=True):
            if free.path.startswith(start):
                parameters[free.path[len(start) :]] = float(value)
        return held.at(parameters)

    def model(self) -> Model:
        """The model at the current values."""
        constants = dict(self.base.constants)
        effects: dict[str, EffectInstance] = dict(self.base.effects)
        added = {name: dict(instance.parameters) for name, instance in self.added.items()}
        parted = self.parted
        ahead = {path: value for path, value in self.by_path.items() if path.startswith("quarter.")}
        for free, value in zip(self.free, self.values, strict=True):
            kind, _, rest = free.path.partition(".")
            if kind == "scale":
                self._scale(rest, float(value), parted, constants, effects)
                if f"quarter.{rest}" in ahead:
                    self._turn(rest, float(value), ahead[f"quarter.{rest}"], effects)
            elif kind == "contact":
                path = f"transmission.contact_{rest}"
                constants[path] = constants[path].at(float(value))
            elif kind == "effects":
                name, _, parameter = rest.partition(".")
                turning = any(
                    p.name == parameter and p.periodic for p in catalogue()[self.added[name].effect].parameters
                )
                added[name][parameter] = math.remainder(value, 2.0 * math.pi) if turning else float(value)
        for name, instance in self.added.items():
            effects[name] = instance.at(added[name])
        return replace(self.base, constants=constants, effects=effects)

    @property
    def by_torque(self) -> bool:
        """Whether torque was measured, so that the inertia can be identified; otherwise only encoders."""
        return any(free.path == "scale.inertia" for free in self.free)

    @property
    def inertia_is_open(self) -> bool:
        """Whether the inertia of the model is only the start of a fit."""
        return any(free.path == "scale.inertia" and free.prior is None for free in self.free)

    @property
    def parted(self) -> bool:
        """Whether motor side and output side have separate free parameters."""
        return any(free.path.startswith(SIDED) for free in self.free)

    def _scale(
        self,
        what: str,
        factor: float,
        parted: bool,
        constants: dict[str, ConstantValue],
        effects: dict[str, EffectInstance],
    ) -> None:
        """Scale a constant, or the size of a base effect; on one side only if each side has its own factor."""
        if what in ("inertia", "output_inertia"):
            sides = {"output_inertia": INERTIAS[-1:], "inertia": INERTIAS[:-1] if parted else INERTIAS}
            for path in sides[what]:
                constants[path] = constants[path].at(constants[path].value * factor)
            return
        effect = DRY_FRICTION if what == "output_coulomb" else what
        sided = {"output_coulomb": ("output",), DRY_FRICTION: ("motor",) if parted else ("motor", "output")}
        size = catalogue()[effect].parameters[0].name
        for name, instance in self.base.active.items():
            if instance.effect == effect and instance.options.get("side") in sided.get(what, ("motor", "output", None)):
                parameters = {**instance.parameters, size: instance.parameters[size] * factor}
                effects[name] = instance.at(parameters)

    def _turn(self, id: str, along: float, ahead: float, effects: dict[str, EffectInstance]) -> None:
        """Replace waves of the base by ``along`` times themselves plus ``ahead`` times a copy a quarter period ahead.

        A wave of unknown amplitude and phase is thus a sum of two waves: a linear regression finds both, and the
        amplitude is never negative.
        """
        effect = catalogue()[id]
        size, angle = effect.parameters[0], effect.wave_angle
        assert angle is not None  # only waves have a ``quarter`` parameter
        for name, instance in self.base.active.items():
            if instance.effect == id:
                turned = instance.parameters[angle.name] + math.atan2(ahead, along)
                parameters = {
                    **instance.parameters,
                    size.name: instance.parameters[size.name] * math.hypot(along, ahead),
                    angle.name: math.remainder(turned, 2.0 * math.pi),
                }
                effects[name] = instance.at(parameters)

    def with_effect(self, id: str, options: Mapping[str, str], parameters: Mapping[str, float]) -> Hypothesis:
        """Hypothesis with one more effect, its parameters free, starting from ``parameters`` (others: defaults)."""
        effect = table_in(catalogue()[id], self.base.units)
        name, number = id, 2
        while name in self.added or name in self.base.effects:
            name, number = f"{id}_{number}", number + 1
        options = {**effect.default_options(), **options}
        table = effect.parameters_with(options)
        instance = EffectInstance(id, options, {p.name: parameters.get(p.name, p.default) for p in table})
        free = list(self.free)
        values = list(self.values)
        for p in table:
            if p.at_rest:
                continue
            start = instance.parameters[p.name]
            # without torque data, own units follow only from a typical speed, so a default size does not apply
            size = abs(start) if start and not self.by_torque else max(abs(start), abs(p.default), 1e-6)
            step = 1e-3 if p.periodic else (0.01 if p.neutral is None else 1e-3) * size
            lower, upper = p.lower, p.upper
            if p.periodic:
                lower, upper = -math.inf, math.inf
            elif p.neutral is None and p.starts and math.isinf(p.upper):
                # far outside its starts an effect cannot be distinguished from none
                # without torque data much farther: own units follow only from a typical speed
                beyond = SEARCHED_BEYOND_STARTS if self.by_torque else SEARCHED_BEYOND_STARTS**5
                lower, upper = max(lower, min(p.starts) / beyond), min(upper, max(p.starts) * beyond)
            free.append(Free(f"effects.{name}.{p.name}", lower, upper, step))
            values.append(start)
        more = replace(self, added={**self.added, name: instance}, free=tuple(free), values=np.array(values))
        return more.with_sides()

    def with_sides(self) -> Hypothesis:
        """Add the parameters that only show with backlash or compliance; drop them for a rigid transmission."""
        held = self.held
        now = self.by_path
        wanted: list[tuple[Free, float]] = []
        if held & set(COMPLIANT_EFFECTS) or self.base.kinds["transmission"] == "two_inertia":
            sides = {DRY_SCALE: Free("scale.output_coulomb", 0.0, SEARCHED_BEYOND_STARTS, 1e-2, (1.0, 0.5))}
            if self.by_torque:  # otherwise the inertia is the unit of all torques
                sides["scale.inertia"] = Free(
                    "scale.output_inertia", 1.0 / SEARCHED_BEYOND_STARTS, SEARCHED_BEYOND_STARTS, 5e-3, (1.0, TOLERANCE)
                )
            wanted += [(self._as_open_as(path, side), now.get(path, 1.0)) for path, side in reversed(sides.items())]
            if not self.by_torque and SPRING not in held:  # more would wind up the teeth, which is not backlash
                wanted = [(side if side.prior else replace(side, upper=1.0), value) for side, value in wanted]
        if PLAY in held and SPRING not in held:
            wanted += self._teeth()
        paths = [free.path for free, _ in wanted]
        keep = [k for k, f in enumerate(self.free) if f.path in paths or not f.path.startswith(SIDED)]
        new = [(free, value) for free, value in wanted if free.path not in {f.path for f in self.free}]
        return replace(
            self,
            free=(*(self.free[k] for k in keep), *(free for free, _ in new)),
            values=np.append(self.values[keep], [value for _, value in new]),
        )

    def _teeth(self) -> list[tuple[Free, float]]:
        """Contact of the teeth, a spring of unknown stiffness: it starts as stiff as the samples resolve.

        Without torque data, soft teeth cannot be distinguished from backlash: then the contact is held at its stiffest,
        or at the file's value.
        """
        inertia = self.base.value("machine.output_inertia")
        stiffness, damping = inertia * RESOLVED**2, 2.0 * inertia * RESOLVED
        if not self.by_torque:
            held = {"stiffness": STIFFEST * stiffness, "damping": math.sqrt(STIFFEST) * damping}
            own = {name: self.base.constants[f"transmission.contact_{name}"] for name in held}
            held |= {name: constant.value for name, constant in own.items() if constant.source != ABSENT}
            return [  # held with a tight prior as well, so that other errors do not grow
                (Free(f"contact.{name}", value, value, 0.02 * value, (value, EXACT * value)), value)
                for name, value in held.items()
            ]
        return [
            (Free("contact.stiffness", 0.3 * stiffness, STIFFEST * stiffness, 0.02 * stiffness), stiffness),
            (Free("contact.damping", 0.0, 9.0 * damping, 0.02 * damping), damping),
        ]

    def _as_open_as(self, path: str, side: Free) -> Free:
        """Scale of the output side, as free as the total at ``path`` if that is open."""
        whole = next((free for free in self.free if free.path == path), None)
        if whole is not None and not self.by_torque and whole.lower == whole.upper:
            return replace(whole, path=side.path)
        if whole is None or whole.prior is not None:
            return side
        return replace(side, lower=whole.lower, upper=whole.upper, prior=None)

    def as_the_file_shares(self) -> dict[str, float]:
        """By path: factors that keep the sums of inertia and dry friction but divide them as the model file does."""
        model, base = self.model(), self.base
        inertia = sum(model.value(path) for path in INERTIAS) / sum(base.value(path) for path in INERTIAS)
        dry = [name for name, instance in base.active.items() if instance.effect == DRY_FRICTION]
        torque, nominal = (sum(m.effects[name].parameters["torque"] for name in dry) for m in (model, base))
        friction = torque / nominal if nominal > 0.0 else 1.0
        factors = dict(zip(SHARES, (inertia, inertia, friction, friction), strict=True))
        return {free.path: factors[free.path] for free in self.free if free.path in factors}

    def teeth_of_the_file(self) -> dict[str, float]:
        """By path: stiffness and damping of the contact from the model file, where they are free.

        Those that the file does not give are the reference bench's. Far smaller wheels are lighter than such teeth are
        stiff, and a simulation of them never ends: then there are none.
        """
        held = {
            free.path: self.base.constants[free.path.replace("contact.", "transmission.contact_")]
            for free in self.free
            if free.path.startswith("contact.")
        }
        values = {path: constant.value for path, constant in held.items()}
        if any(constant.source == ABSENT for constant in held.values()):
            assembly = assemble(self.put(values).model())
            if longest_step(assembly)[0] < own_step(self.base, None):
                return {}
        return values

    def with_generic_basis(self, name: str, columns: int) -> Hypothesis:
        """Hypothesis with one more generic basis: ``columns`` coefficients of the basis of that name."""
        more = tuple(Free(f"basis.{name}.{k}", -math.inf, math.inf, 1.0) for k in range(columns))
        return replace(self, free=(*self.free, *more), values=np.append(self.values, np.zeros(columns)))

    @property
    def generic_bases(self) -> tuple[str, ...]:
        """The names of the generic bases."""
        return tuple(dict.fromkeys(f.path.split(".")[1] for f in self.free if f.path.startswith("basis.")))

    def without_generic_basis(self, name: str) -> Hypothesis:
        """The hypothesis without one generic basis."""
        return self._less(f"basis.{name}.")

    def without_generic_bases(self) -> Hypothesis:
        """The hypothesis without all of them: they describe only their own recordings."""
        return self._less("basis.")

    def _less(self, *prefixes: str, **changed: Any) -> Hypothesis:
        """The hypothesis without the free parameters whose paths begin with these ``prefixes``."""
        keep = [k for k, f in enumerate(self.free) if not f.path.startswith(prefixes)]
        return replace(self, free=tuple(self.free[k] for k in keep), values=self.values[keep], **changed)

    def with_torques_times(self, factor: float) -> Hypothesis:
        """Multiply every free torque, stiffness, damping and inertia, as a different torque constant would."""
        return self.at(np.where(self._mechanical, factor * self.values, self.values))

    @property
    def _mechanical(self) -> np.ndarray:
        """Mask (k,) of the parameters that are torques, stiffnesses, dampings or inertias."""

        def mechanical(path: str) -> bool:
            p = self.parameter_of(path)
            if p is None:
                return path.partition(".")[0] in ("scale", "quarter", "contact", "basis")
            return p.unit.startswith(("N m", "kg m"))

        return np.array([mechanical(free.path) for free in self.free], bool)

    def factor_to_file(self) -> float:
        """The factor on all torques that brings the constants closest to the model file."""
        rows = [
            (value / free.prior[1], free.prior[0] / free.prior[1])
            for free, value, moves in zip(self.free, self.values, self._mechanical, strict=True)
            if free.prior is not None and moves
        ]
        return sum(v * mean for v, mean in rows) / max(sum(v**2 for v, _ in rows), 1e-30)

    def balanced(self) -> Hypothesis:
        """Move the constants closest to their file values, if an added torque constant allows it.

        The prediction is unchanged, except for torques of the model file that are not free.
        """
        for name, instance in self.added.items():
            if instance.effect == TORQUE_FACTOR:
                path = f"effects.{name}.scale"
                free = next(free for free in self.free if free.path == path)
                scale = self.by_path[path]
                factor = min(max(self.factor_to_file() * scale, free.lower), free.upper) / scale
                return self.with_torques_times(factor).put({path: factor * scale})
        return self

    def with_factor_as_constant(self, name: str, tolerance: float) -> Hypothesis:
        """The hypothesis with an added factor on the torque constant as a constant, known within a ``tolerance``.

        If that is infinite it is entirely free.
        """
        instance = self.added[name]
        path, scale = f"effects.{name}.scale", f"scale.{TORQUE_FACTOR}"
        prior = None if math.isinf(tolerance) else (1.0, max(tolerance, EXACT))
        ends = {"lower": 1.0 / ANY_SIZE, "upper": ANY_SIZE} if prior is None else {}
        return replace(
            self,
            base=replace(self.base, effects={**self.base.effects, name: instance.at({"scale": 1.0})}),
            added={other: held for other, held in self.added.items() if other != name},
            free=tuple(
                replace(free, path=scale, prior=prior, **ends) if free.path == path else free for free in self.free
            ),
        )

    def without(self, *names: str) -> Hypothesis:
        """The hypothesis without some added effects."""
        added = {name: held for name, held in self.added.items() if name not in names}
        return self._less(*(f"effects.{name}." for name in names), added=added).with_sides()


def dry_friction(instances: Iterable[EffectInstance]) -> dict[str, float]:
    """Level of dry friction [N m] on the motor's and on the output's side, of these effects."""
    found = {"motor": 0.0, "output": 0.0}
    for instance in instances:
        if instance.effect == DRY_FRICTION:
            found[instance.options["side"]] += instance.parameters["torque"]
    return found
