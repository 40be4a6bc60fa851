"""Plausible: what an explanation must be beside fitting well, so that a wrong model is not dressed up.

Where the true cause is in no catalogue, two or three effects together can stand in for it. They give themselves away:
constants of the machine end far from what its file says, a size is hardly known to be there at all, or each constant
has a cause of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ...criteria import COST_PARAMETER, LEAST_SIZE, LIKELY, SIGNIFICANT, STRAINED_BESIDE, STRAINED_TOGETHER
from ...effects import Trait, catalogue, effects_with
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit, prior_rows
from ...identification.hypothesis import LAG, SIDED
from ...identification.on_bound import reached_bound
from ...identification.uncertainty import covariance, scaled_inverse
from ...model.roles import FRICTION, TORQUE_FACTOR
from .reversals import shows_where_slowest
from .worth import NOTHING_ELSE, is_lacked, largest_rms_reduction

OVER = {"inertia": "acceleration"} | {id: catalogue()[id].depends_on for id in FRICTION}


def strained(f: Fit) -> tuple[str, ...]:
    """What the constants act over that ended far from what the model's file says, one alone or all together.

    Of inertia and friction that a gearbox parts, it is the sums: their shares are hardly known.
    """
    values = {**f.hypothesis.by_path, **f.hypothesis.as_the_file_shares()}
    off = {
        free.path: abs(values[free.path] - free.prior[0]) / free.prior[1]
        for free in f.hypothesis.free
        if free.prior is not None and free.path != LAG and not free.path.startswith(SIDED)
    }
    told_by_constants = any(catalogue()[id].depends_on in NOTHING_ELSE for id in f.hypothesis.effects)
    most = STRAINED_BESIDE if told_by_constants else STRAINED_TOGETHER
    limit = LIKELY if sum(z**2 for z in off.values()) > most else SIGNIFICANT
    over = [OVER[path.partition(".")[2]] for path, z in off.items() if z > limit]
    return tuple(dict.fromkeys(over))


def insignificant(problem: EquationErrorProblem, f: Fit) -> str | None:
    """The added effect that is the least sure to be there, where that is not sure enough; see ``uncertain``."""
    return next(uncertain(problem, f), None)


def uncertain(problem: EquationErrorProblem, f: Fit) -> Iterator[str]:
    """The added effects that are not sure enough to be there, the first to go first.

    A size is judged with the effect's own shape (a speed, an angle) held: next to nothing has no shape. With its shape
    free it must still be told from nothing, 49 ± 57 mN m is no number to give anybody, unless it is a share, which has
    bounds to both sides; and so must what the effect does, surely where constants are open, which leaves more than
    noise over. Not asked of what constants off their file show: how far they are off was that effect's worth; nor,
    beside a generic basis, which fits anything, of what every machine has. Where constants are open, no shape may stand
    on its bound either, and what turns with a shaft must show elsewhere than beside standstill. Of two that take each
    other's place it is the later one, which explains less.
    """
    away = {}
    sure = SIGNIFICANT if f.hypothesis.base.is_open else LIKELY
    spread = covariance(problem, f)
    paths = [free.path for free in f.hypothesis.free]
    for name in reversed([*f.hypothesis.added]):
        instance = f.hypothesis.instance(name)
        effect = catalogue()[instance.effect]
        size = effect.parameters[0]
        if f.hypothesis.base.is_open and (_shape_on_bound(problem, f, name) or shows_where_slowest(problem, f, name)):
            yield name
            continue
        if f.hypothesis.generic_bases and is_lacked(f.hypothesis, effect.id):
            continue
        if effect.depends_on not in NOTHING_ELSE and f"effects.{name}.{size.name}" in paths:
            k = paths.index(f"effects.{name}.{size.name}")
            others = [i for i, path in enumerate(paths) if path.startswith(f"effects.{name}.") and i != k]
            shape = others if size.neutral is not None else []
            with_shape = spread[k, shape]
            variance = spread[k, k] - with_shape @ scaled_inverse(spread[np.ix_(shape, shape)]) @ with_shape
            # of a stiffness, it is the softness that is there or not: as many standard errors from none
            off = instance.parameters[size.name] - (0.0 if size.neutral is None else size.neutral)
            away[name] = abs(off) / math.sqrt(max(float(variance), 1e-300))
            # over a part of a turn, an amplitude and its angle take each other's place
            periodic = any(p.periodic for p in effect.parameters)
            needed = 1.0 if periodic else 0.0 if shape and math.isfinite(size.upper) else LIKELY
            hardly_known = abs(off) < needed * math.sqrt(max(float(spread[k, k]), 0.0))
            if hardly_known or (not periodic and _sureness(f, spread, off, k, shape) < sure):
                del away[name]
                yield name
    yield from (name for name in sorted(away, key=away.__getitem__) if away[name] < SIGNIFICANT)


def _shape_on_bound(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether the shape of an added effect (a speed, a time) ran against the end of what the recordings reach.

    Where constants are open, what has no shape of its own there is a part of them that they do not fit.
    """
    effect = catalogue()[f.hypothesis.instance(name).effect]
    shape = {f"effects.{name}.{p.name}" for p in effect.parameters[1:] if not p.periodic}
    numbers = zip(f.hypothesis.free, f.hypothesis.values, *problem.bounds(f.hypothesis), strict=True)
    return any(
        free.path in shape and reached_bound(float(value), float(lower), float(upper), math.inf, abs(value))
        for free, value, lower, upper in numbers
    )


def _sureness(f: Fit, spread: np.ndarray, off: float, size: int, shape: Sequence[int]) -> float:
    """Standard errors by which what an effect does in the rows that were judged is away from nothing.

    ``spread`` (k, k) is the covariance of all free numbers, ``size`` and ``shape`` are the effect's among them, ``off``
    how far its size is from none. Where a size and its shape take each other's place, each is hardly known and what
    they do together well: a lubricant that thins by a share at one speed, or by more at a higher one.
    """
    own = [size, *shape]
    done = off * f.jacobian[:, size]  # what the effect does, to first order
    changes = f.jacobian[:, own].T @ done / max(float(done @ done), 1e-300)
    return 1.0 / math.sqrt(max(float(changes @ spread[np.ix_(own, own)] @ changes), 1e-300))


def only_constants(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """Added effects that nothing but constants far from their file calls for, where these are several.

    One cause may stand behind one constant; a cause for each is no explanation. And what is to stand behind all of
    them must do so: where one constant alone is off, and only half put right, it is not what all have in common.
    """
    for name, instance in f.hypothesis.added.items():
        if instance.effect == TORQUE_FACTOR:
            unscaled = fit(problem, f.hypothesis.without(name), 4, known=f)
            if f.prior_cost > _beside_the_worst(unscaled) + COST_PARAMETER:
                return (name,)
    like = effects_with(Trait.LIKE_A_CONSTANT)
    alike = [name for name, instance in f.hypothesis.added.items() if instance.effect in like]
    if len(alike) < 2:
        return ()
    bare = {name: fit(problem, f.hypothesis.without(name), 4, known=f) for name in alike}
    found = tuple(name for name in alike if largest_rms_reduction(problem, bare[name], f) < LEAST_SIZE)
    return found if len(found) > 1 else ()


def _beside_the_worst(f: Fit) -> float:
    """What the constants cost that are off their file, but for the one that is off the most."""
    residuals, _ = prior_rows(f.hypothesis)
    return float(residuals @ residuals - np.max(residuals**2, initial=0.0))
