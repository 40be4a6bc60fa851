"""Plausible: conditions beyond a good fit, so that a wrong model is not made to look right.

If the true cause is not in the catalogue, two or three effects together can imitate it. The signs are: constants of the
machine end far from the values of its file, the size of an effect is barely distinguishable from zero, or each constant
gets an effect of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache

import numpy as np

from ...criteria import (
    COST_PARAMETER,
    DEPENDS,
    LEAST_SIZE,
    LIKELY,
    NEGLIGIBLE,
    PART,
    SIGNIFICANT,
    STRAINED_BESIDE,
    STRAINED_TOGETHER,
)
from ...effects import NOTHING_KNOWN, Effect, Parameter, Trait, catalogue, effects_with
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit, prior_rows
from ...identification.hypothesis import LAG, SIDED
from ...identification.on_bound import is_simpler_law, reached_bound
from ...identification.uncertainty import covariance, scaled_inverse
from ...model.own_units import table_in
from ...model.roles import FRICTION, TORQUE_FACTOR
from .few_rows import shows_in_few_rows
from .in_place_of_dry_friction import in_place_of_dry_friction
from .reversals import shows_where_slowest
from .worth import NOTHING_ELSE, is_lacked, largest_rms_reduction, penalised_gain

OVER = {"inertia": "acceleration"} | {id: catalogue()[id].depends_on for id in (*FRICTION, TORQUE_FACTOR)}


def strained(f: Fit) -> tuple[str, ...]:
    """Quantities that the constants far from the model file act on; each constant is tested alone and all together.

    With backlash or compliance, inertia and friction are tested by their sums: their shares are poorly known.
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
    """The least certain added effect, if it is not certain enough; see ``uncertain``."""
    return next(uncertain(problem, f), None)


def uncertain(problem: EquationErrorProblem, f: Fit) -> Iterator[str]:
    """The added effects that are not certain enough, the first to be removed first.

    The rules:

    * The size must differ from nothing with the effect's own shape (a speed, an angle) held, because an effect of no
      size has no shape.
    * With its shape free, the size must still differ from nothing: 49 ± 57 mN m is not a reportable number. Exception:
      a share, which is bounded on both sides.
    * With open constants, a size known to a third or half suffices if the rows lose much without the effect: it must
      otherwise be as sure as the constants.
    * What the effect does in the rows must differ from nothing as well; with open constants by more, because more than
      noise is left there.
    * Effects that show only in constants off their file are exempt: how far these were off was the effect's gain. So
      are effects that every machine has, in the presence of a generic basis, which fits anything.
    * With known constants no factor may end on a bound of what is possible, or within its error of one: the data ask
      for more than any machine has.
    * With open constants no shape may end on its bound, no share may be one that its effect's file calls impossible
      for any machine, an effect over a shaft angle must show away from standstill and in more than a few rows, and no
      friction may take the place of the machine's dry friction.

    An uncertain shape alone is no reason: size and shape may trade off while their joint action is well known (see
    ``_sureness``).

    If two effects can replace each other, the later one goes first, because it explains less.
    """
    away = {}
    needed_by_rows = cache(lambda name: _needed(problem, f, name))
    sure = SIGNIFICANT if f.hypothesis.base.is_open else LIKELY
    whole, waves = covariance(problem, f), _torque_waves(problem, f)
    of_waves = covariance(problem, f, by_torque=True) if waves else whole
    paths = [free.path for free in f.hypothesis.free]
    for name in reversed([*f.hypothesis.added]):
        instance = f.hypothesis.instance(name)
        effect = table_in(catalogue()[instance.effect], f.hypothesis.base.units)
        size = effect.parameters[0]
        spread = of_waves if name in waves else whole
        if f.hypothesis.base.is_open and (
            _shape_on_bound(problem, f, name)
            or _never_possible(effect, instance.parameters)
            or shows_where_slowest(problem, f, name)
            or shows_in_few_rows(problem, f, name)
            or in_place_of_dry_friction(problem, f, name)
        ):
            yield name
            continue
        path = f"effects.{name}.{size.name}"
        k = paths.index(path) if path in paths else None
        error = 0.0 if k is None else math.sqrt(max(float(spread[k, k]), 0.0))
        if not f.hypothesis.base.is_open and _size_on_bound(size, instance.parameters[size.name], error):
            yield name
            continue
        if f.hypothesis.generic_bases and is_lacked(f.hypothesis, effect.id):
            continue
        if effect.depends_on not in NOTHING_ELSE and k is not None:
            others = [i for i, path in enumerate(paths) if path.startswith(f"effects.{name}.") and i != k]
            shape = others if size.neutral is not None else []
            with_shape = spread[k, shape]
            variance = spread[k, k] - with_shape @ scaled_inverse(spread[np.ix_(shape, shape)]) @ with_shape
            # for a stiffness, the compliance is tested: as many standard errors from zero
            off = instance.parameters[size.name] - (0.0 if size.neutral is None else size.neutral)
            away[name] = abs(off) / math.sqrt(max(float(variance), 1e-300))
            # over part of a turn, an amplitude and its angle trade off against each other
            periodic = any(p.periodic for p in effect.parameters)
            needed = 1.0 if periodic else 0.0 if shape and math.isfinite(size.upper) else LIKELY
            hardly_known = abs(off) < needed * math.sqrt(max(float(spread[k, k]), 0.0))
            sureness = math.inf if periodic else _sureness(f, spread, off, k, shape)
            if hardly_known or (sureness < sure and not (sureness >= LIKELY and needed_by_rows(name))):
                del away[name]
                yield name
    for name in sorted(away, key=away.__getitem__):
        if away[name] < SIGNIFICANT and not (away[name] >= LIKELY and needed_by_rows(name)):
            yield name


def _torque_waves(problem: EquationErrorProblem, f: Fit) -> frozenset[str]:
    """The added waves over a shaft's angle that show in the torque alone, beside backlash or compliance.

    A contact of teeth that is far from right leaves most of the encoders' difference, and makes all parameters that it
    acts on uncertain; a wave of the motor's torque it does not imitate.
    """
    if not f.parted or not problem.size:
        return frozenset()
    slopes = f.slopes()
    return frozenset(
        name
        for name, held in f.hypothesis.added.items()
        if catalogue()[held.effect].depends_on == "order"
        and not any(slopes[path][problem.size :].any() for path in slopes if path.startswith(f"effects.{name}."))
    )


def _needed(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether constants are open, and the rows lose several times what a dependence must gain without an added effect.

    A standard error describes the misfit close to its minimum. The size of an effect that bends a curve (a stiffness, a
    level that decays with speed) may be known to a third only, in rows that nothing else explains.
    """
    if not f.hypothesis.base.is_open:
        return False
    return penalised_gain(fit(problem, f.hypothesis.without(name), 4, known=f), f) > SIGNIFICANT * DEPENDS


def _shape_on_bound(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether the shape of an added effect (a speed, a time) ended on the limit of what the recordings reach.

    With open constants, an effect without a shape of its own fits a part of them that the constants do not.
    """
    effect = catalogue()[f.hypothesis.instance(name).effect]
    shape = {f"effects.{name}.{p.name}": p for p in effect.parameters[1:] if not p.periodic}
    numbers = zip(f.hypothesis.free, f.hypothesis.values, *problem.bounds(f.hypothesis), strict=True)
    return any(
        free.path in shape
        and not is_simpler_law(shape[free.path], float(value))
        and reached_bound(float(value), float(lower), float(upper), math.inf, abs(value))
        for free, value, lower, upper in numbers
    )


def _size_on_bound(size: Parameter, value: float, error: float) -> bool:
    """Whether a size that is neutral in between (a torque constant over its nominal one) is as far off as it may be.

    A bound within its standard ``error`` counts as reached, if it is near.
    """
    if size.neutral is None or not size.lower < size.neutral < size.upper:
        return False
    bound = size.upper if value > size.neutral else size.lower
    near = min(max(error, NEGLIGIBLE * abs(bound)), PART * abs(bound - size.neutral))
    return math.isfinite(bound) and abs(bound - value) <= near


def _never_possible(effect: Effect, parameters: Mapping[str, float]) -> bool:
    """Whether a share of an effect is one that no machine has: friction of the teeth of 0.6 of what they carry.

    The effect then fits a part of the constants, or an unknown cause.
    """
    return any(rule.never and rule.when(parameters, NOTHING_KNOWN) for rule in effect.implausible)


def _sureness(f: Fit, spread: np.ndarray, off: float, size: int, shape: Sequence[int]) -> float:
    """Standard errors by which the action of an effect in the judged rows differs from nothing.

    ``spread`` (k, k) is the covariance of all free numbers, ``size`` and ``shape`` are the effect's indices in it,
    ``off`` is how far its size is from neutral. If size and shape trade off, each is poorly known but their joint
    action is well known: a lubricant that thins by some share at one speed, or by more at a higher one.
    """
    own = [size, *shape]
    done = off * f.jacobian[:, size]  # action of the effect, to first order
    changes = f.jacobian[:, own].T @ done / max(float(done @ done), 1e-300)
    return 1.0 / math.sqrt(max(float(changes @ spread[np.ix_(own, own)] @ changes), 1e-300))


def only_constants(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """Added effects that are supported only by constants far from their file, if there are several.

    One cause may explain one constant; a separate cause for each constant is no explanation. A common cause must
    explain all of them: if only one constant is off, and only half corrected, it is not the common cause.
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
    """Prior cost of the constants off their file, without the one that is off the most."""
    residuals, _ = prior_rows(f.hypothesis)
    return float(residuals @ residuals - np.max(residuals**2, initial=0.0))
