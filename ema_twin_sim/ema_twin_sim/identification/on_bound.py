"""Parameters on a search bound: the recordings favour a value beyond it, or do not determine them."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping

import numpy as np

from ..criteria import LIKELY, NEARLY_ALL, NEGLIGIBLE, SIGNIFICANT, SMALL
from ..effects import Parameter, catalogue
from ..effects.catalogue import is_own
from ..model import Model
from ..model.constants import CONSTANTS
from ..model.own_units import shown, table_in
from ..model.roles import DRY_FRICTION, FRICTION, TORQUE_FACTOR
from .equation import EquationErrorProblem
from .estimates import standard_errors
from .fit import Fit, prior_rows
from .hypothesis import INERTIAS, Free
from .uncertainty import linearised, scaled_inverse

INERTIA_SHOWN_BY = "hard acceleration: steps, fast sines"
TURNED = (
    "no inertia and no friction is above zero, as if the torque acted against the machine: its sign is turned round; "
    "check the signs of current, torque and positions in the import map (`factor: -1` turns one)"
)
START_ELSEWHERE = "or give the model a value nearer to it to start from"


def reached_bound(value: float, lower: float, upper: float, std: float, scale: float) -> str | None:
    """The bound (``lower`` or ``upper``) that a parameter has reached, if any; ``scale`` is its typical size."""
    for bound, side in ((lower, "lower"), (upper, "upper")):
        if math.isfinite(bound) and abs(value - bound) <= min((1.0 - NEARLY_ALL) * std, NEGLIGIBLE * scale):
            return side
    return None


def is_simpler_law(shape: Parameter, value: float) -> bool:
    """Whether a shape at its own bound of zero is a simpler law: a bristle without damping is Dahl's."""
    return value == shape.lower == 0.0


def on_bounds(problem: EquationErrorProblem, f: Fit, sure: Mapping[str, float]) -> tuple[str, ...]:
    """One sentence for each parameter of an added effect, and each open one of the model, that ended on a bound.

    Before them one on the torque's sign, if the inertia and all friction of an unknown machine ended at their least.
    """
    found = [TURNED] if torque_sign_reversed(problem, f, sure) else []
    for path, side in _ended(problem, f, sure).items():
        kind, _, rest = path.partition(".")
        if side is not None:
            found += _added(f, rest, side) if kind == "effects" else _open(f, rest)
    return tuple(found)


def torque_sign_reversed(problem: EquationErrorProblem, f: Fit, sure: Mapping[str, float] | None = None) -> bool:
    """Whether the torque of an unknown machine acts against it: none of its inertia and friction is above zero.

    Either all ended at their least, or at least one did, and one would surely be negative without bounds and none
    surely positive. What the added effects leave must be more than a small part of the torque: where gravity is nearly
    all of it, a hand that helps outweighs friction. A filtered torque makes the inertia alone negative. And a torque
    constant whose error ended on its bound leaves a torque that friction would have to make good. ``sure`` are the
    standard errors by path, if they are known already.
    """
    paths = {f"scale.{what}" for what in ("inertia", *FRICTION)}
    asked = {k: free.path for k, free in enumerate(f.hypothesis.free) if free.path in paths and free.prior is None}
    if len(asked) < 2 or not problem.size:
        return False
    ended = _ended(problem, f, standard_errors(problem, f) if sure is None else sure)
    if "lower" not in {ended[path] for path in asked.values()} or any(
        ended.get(f"effects.{name}.scale") for name, held in f.hypothesis.added.items() if held.effect == TORQUE_FACTOR
    ):
        return False
    away = _without_bounds(f)
    certain = min(away[k] for k in asked) < -SIGNIFICANT and max(away[k] for k in asked) < LIKELY
    all_ended = all(ended[path] == "lower" for path in asked.values())
    return (all_ended or certain) and _rms_left(problem, f) > SMALL


def _without_bounds(f: Fit) -> np.ndarray:
    """Standard errors (k,) by which each free parameter of a fit differs from zero at the minimum without bounds.

    To first order, as inertia and friction act.
    """
    near, (known, _) = linearised(f), prior_rows(f.hypothesis)
    spread = scaled_inverse(near.information)
    best = f.hypothesis.values + spread @ (near.slopes.T @ near.residual + near.priors.T @ known)
    return best / np.sqrt(np.maximum(np.diag(spread), 1e-300))


def _rms_left(problem: EquationErrorProblem, f: Fit) -> float:
    """RMS of the torque that a fit leaves, over that of the measured torque."""
    torque = slice(problem.size)
    whole = (f.weights * problem.measured)[torque]
    return float(np.linalg.norm(f.residual[torque]) / max(np.linalg.norm(whole), 1e-300))


def _ended(problem: EquationErrorProblem, f: Fit, sure: Mapping[str, float]) -> dict[str, str | None]:
    """By path, of added effects and of the open model: the bound that a parameter ended on, if any."""
    h = f.hypothesis
    return {
        free.path: reached_bound(
            float(value), float(lower), float(upper), sure.get(free.path, math.inf), _typical(f, free)
        )
        for free, value, lower, upper in zip(h.free, h.values, *problem.bounds(h), strict=True)
        if free.prior is None and free.path.partition(".")[0] in ("effects", "scale")
    }


def _typical(f: Fit, free: Free) -> float:
    """The typical size of a free parameter."""
    if not free.path.startswith("effects."):
        return 1.0
    name, _, parameter = free.path.removeprefix("effects.").partition(".")
    instance = f.hypothesis.added[name]
    effect = table_in(catalogue()[instance.effect], f.hypothesis.base.units)
    p = next(p for p in effect.parameters if p.name == parameter)
    return max(abs(f.hypothesis.by_path[free.path]), abs(p.default)) or 1.0


def _added(f: Fit, rest: str, side: str) -> list[str]:
    """For an added effect."""
    name, _, parameter = rest.partition(".")
    instance = f.hypothesis.instance(name)
    effect = catalogue()[instance.effect]
    p = next(p for p in effect.parameters if p.name == parameter)
    if p is not effect.parameters[0] and is_simpler_law(p, instance.parameters[parameter]):
        return []
    faster = p.driven and side == "upper"
    remedy = "faster motion" if faster else effect.shown_by
    written = with_unit(f.hypothesis.base, instance.parameters[parameter], p.unit, angle=p.periodic)
    return [f"{name}: {parameter} is on its bound {written}; record {remedy}, or hold {parameter} at what is known"]


def own_on_bounds(tried: Iterable[Fit], added: Container[str]) -> tuple[str, ...]:
    """One sentence for each shape of a user's own effect that ended, in fits that were ``tried``, on its file's bound.

    Of effects that are not among those ``added``: a bound that the machine is beyond keeps a right effect out.
    """
    found: dict[str, str] = {}
    for f in tried:
        base = f.hypothesis.base
        for name, instance in f.hypothesis.added.items():
            if instance.effect in added or not is_own(catalogue()[instance.effect]):
                continue
            for p in table_in(catalogue()[instance.effect], base.units).parameters[1:]:
                value = f.hypothesis.by_path.get(f"effects.{name}.{p.name}", math.nan)
                ended = None if p.periodic else reached_bound(value, p.lower, p.upper, math.inf, abs(value))
                if ended and not is_simpler_law(p, value):
                    bound = with_unit(base, getattr(p, ended), p.unit)
                    found.setdefault(
                        f"{name}.{p.name}",
                        f"{name}: tried and not added; its {p.name} ended on the {ended} bound of your file, {bound}: "
                        "widen it there if the machine may be beyond",
                    )
    return tuple(found.values())


def _open(f: Fit, what: str) -> list[str]:
    """For an open inertia, or the sizes of an open effect: the current model values."""
    base, model = f.hypothesis.base, f.hypothesis.model()
    if what in ("inertia", "output_inertia"):
        output = what == "output_inertia"
        parted = [path for path in INERTIAS if not f.hypothesis.parted or (path == INERTIAS[-1]) == output]
        paths = [path for path in parted if base.value(path) > 0.0]
        return [
            f"{base.shown_path(path)} is on its bound {with_unit(base, model.value(path), CONSTANTS[path].unit)}; "
            f"record {INERTIA_SHOWN_BY}, {START_ELSEWHERE}"
            for path in paths
        ]
    id = DRY_FRICTION if what == "output_coulomb" else what
    size = catalogue()[id].parameters[0]
    return [
        f"{name}: {size.name} is on its bound {with_unit(base, model.effects[name].parameters[size.name], size.unit)}; "
        f"record {catalogue()[id].shown_by}, {START_ELSEWHERE}"
        for name, instance in base.active.items()
        if instance.effect == id
    ]


def with_unit(model: Model, value: float, unit: str, *, angle: bool = False) -> str:
    """A value with its unit; for a linear machine in that machine's unit."""
    value, unit = (value, unit) if angle else shown(model, value, unit)
    return f"{value:.4g}" if unit == "1" else f"{value:.4g} {unit}"
