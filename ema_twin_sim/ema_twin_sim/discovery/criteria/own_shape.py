"""Own shape: whether an effect explains as much as any dependence on the same quantity, if something is unknown.

If no effect explains the rest, an effect that was found may only imitate the unknown cause: a bump of friction over the
speed looks like Stribeck friction. Then a basis of any shape over that quantity explains much more than the effect. If
the effect's own shape explains what the basis explains, it is that effect, whatever else is left. A basis explains more
by chance as well, the more so the more neighbouring rows resemble each other, as they do if friction wanders.

An encoder error shows in the encoder difference alone and removes most of it. If it removes only a part while something
is unknown, it imitates interpolation error between encoder lines. A late encoder is distinguished from a compliant
gearbox by what it explains in addition to the torque that winds up the gearbox.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...criteria import APART, DEPENDS, INTERPOLATED, MISFIT_DOUBTED, MISFIT_LEFT, MOSTLY, NEARLY_ALL, TOO_MUCH
from ...effects import catalogue
from ...identification.chance import gain_on_correlated_noise
from ...identification.comparable import by_chance, refuse_different_weightings
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.generic_bases import dependence, fit_with_basis, load_bases, order_bases
from ...identification.hypothesis import COMPLIANT_EFFECTS
from ...identification.screening import screen_generic_bases
from ...identification.sensors import delay_shows
from ...model.own_units import is_linear
from .worth import ENCODER_ONLY, is_lacked

TEETH_STEPS = 8
"""Iterations of a fit; the teeth start from the values they had with backlash."""


def by_own_shape(problem: EquationErrorProblem, f: Fit, names: Iterable[str] | None = None) -> tuple[str, ...]:
    """Added effects that explain by their own shape what they do, and those over quantities without a basis.

    ``names`` limits this to some of the added effects.
    """
    return tuple(name for name in (f.hypothesis.added if names is None else names) if _own(problem, f, name))


def imitates(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an added effect explains much less of the torque than another shape over its own quantity does.

    For open constants, which leave a real machine's effects less sure of their shape than known ones do.
    """
    effect = catalogue()[f.hypothesis.added[name].effect]
    wanders = effect.depends_on == "time" and problem.weighting.wander is not None
    if wanders or is_lacked(f.hypothesis, effect.id):
        return False
    bare = fit(problem, f.hypothesis.without(name), 6, known=f)
    refuse_different_weightings(bare, f)
    shapes = _over(problem, bare, shape_over(f, name))
    beside = problem.with_generic_bases(shapes)
    best = _best_basis(beside, bare) if shapes else None
    if best is None:
        return False
    any_shape = fit_with_basis(beside, bare, best)
    columns = len(any_shape.hypothesis.free) - len(bare.hypothesis.free)
    scale = f.variance_inflations[0]
    chance = max(gain_on_correlated_noise(beside, bare, any_shape, best) / scale, by_chance(columns))
    explained = (bare.misfits[0] - f.misfits[0]) / scale
    return explained < MOSTLY * ((bare.misfits[0] - any_shape.misfits[0]) / scale - chance)


def shape_over(f: Fit, name: str) -> str:
    """The quantity over which an added effect has its shape.

    That of a wave with less than a cycle per turn of the output is its position: no shaft repeats so slowly, and over a
    few cycles a load with any course looks like such a wave.
    """
    model = f.hypothesis.model()
    over = catalogue()[model.effects[name].effect].depends_on
    if over != "order" or is_linear(model):
        return over
    slow = model.motor_order(name) * model.value("machine.gear_ratio") < NEARLY_ALL
    return "output_position" if slow else over


def parts_the_encoders(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether backlash, compliance or an encoder's angle error explains the encoder difference, whatever else is left.

    * Compliance or an angle error must explain most of it and leave no more than interpolation error may. Interpolation
      error occurs with a compliant gearbox as well; compliance in place of backlash leaves much more where the output
      is thrown against the teeth.
    * Backlash must leave little of the difference in every recording, because impacts leave more than interpolation
      does.
    * Never true of a late encoder, which looks like a compliant gearbox.
    """
    effect = catalogue()[f.hypothesis.instance(name).effect]
    if effect.id not in {*COMPLIANT_EFFECTS, *ENCODER_ONLY} or effect.delays:
        return False
    parts = [part for part in problem.encoder_parts if part.stop > part.start]
    bare = fit(problem, f.hypothesis.without(name))
    if is_play(f, name):
        parted = _of_the_encoders(problem, bare) / (problem.rows - problem.size)
        if parted <= INTERPOLATED**2:  # compliance or interpolation causes as little as that, too
            return False
        little = (1.0 - NEARLY_ALL) * parted
        return all(_of_these(f, part) <= little * (part.stop - part.start) for part in parts)
    return all(_of_these(f, part) <= _lines(part) for part in parts) and _mostly(problem, f, bare)


def hardly_part(f: Fit) -> bool:
    """Whether the encoders differ by no more than they do on real machines with right models."""
    rows = f.problem.rows - f.problem.size
    return _of_the_encoders(f.problem, f) <= (TOO_MUCH**2 - 1.0) * rows


def explains_the_torque(f: Fit, name: str) -> bool:
    """Whether much of the torque is unexplained without an effect, and almost nothing, or little of that, with it.

    A compliant gearbox pulls in such effects only as far as they resemble it; the mismatch then remains visible.
    """
    problem = f.problem
    bare = fit(problem, f.hypothesis.without(name))
    without, beside = (one.misfits[0] / max(problem.size, 1) for one in (bare, f))
    little = min(MISFIT_LEFT, 1.0 + (1.0 - MOSTLY) * (without - 1.0))
    return without > MISFIT_LEFT and beside <= max(MISFIT_DOUBTED, little)


def is_play(f: Fit, name: str) -> bool:
    """Whether an added effect is backlash: a compliant effect whose size is a width in rad."""
    effect = catalogue()[f.hypothesis.instance(name).effect]
    return effect.id in COMPLIANT_EFFECTS and effect.parameters[0].unit == "rad"


def only_teeth(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether the teeth alone, with zero backlash width, explain much of the encoder difference that backlash explains.

    That is, the width removes less than ``MOSTLY`` of what the teeth leave. The teeth wind up as a shaft does. Together
    with a width they absorb what a compliance leaves in the presence of encoder errors.
    """
    width = catalogue()[f.hypothesis.instance(name).effect].parameters[0]
    teeth = fit(problem, f.hypothesis.holding({f"effects.{name}.{width.name}": 0.0}), TEETH_STEPS)
    return not _mostly(problem, f, teeth)


def follows_laws(problem: EquationErrorProblem, f: Fit) -> bool:
    """Whether the torque is explained to the sensors' noise, with friction that does not wander.

    Then nothing but a wrong shape leaves a dependence on the effect's own quantity: gravity in place of a spring leaves
    a third of a per cent of what it explains. Real friction follows no law as exactly, and leaves more than noise.
    """
    return problem.weighting.wander is None and f.misfits[0] <= MISFIT_LEFT * problem.size


def _own(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    effect = catalogue()[f.hypothesis.added[name].effect]
    over = effect.depends_on
    if effect.delays and not f.parted:
        return delay_shows(problem, f)
    bare = fit(problem, f.hypothesis.without(name), 6, known=f)
    if effect.id in ENCODER_ONLY:
        return _mostly(problem, f, bare)
    shapes = _over(problem, bare, over)
    if not shapes:  # no generic basis over this quantity
        return True
    refuse_different_weightings(bare, f)
    took = bare.misfits[0] - f.misfits[0]
    if took < DEPENDS * f.variance_inflations[0]:
        return False
    beside = problem.with_generic_bases(shapes)
    best = _best_basis(beside, bare)
    if best is None:
        return True
    any_shape = fit_with_basis(beside, bare, best)
    scale = f.variance_inflations[0]
    columns = len(any_shape.hypothesis.free) - len(bare.hypothesis.free)
    by_noise = gain_on_correlated_noise(beside, bare, any_shape, best) / scale
    # beyond what ``_gained`` takes off for the numbers; the order itself is one more
    chance = max(by_noise - by_chance(columns), by_chance(1 if over == "order" else 0))
    gained = _gained(bare, f, scale)
    # it exists on every machine, even if its law fits poorly while it warms up or wanders
    lacked = is_lacked(f.hypothesis, effect.id)
    as_any = gained >= (MOSTLY if lacked else NEARLY_ALL) * (_gained(bare, any_shape, scale) - chance)
    if as_any and (lacked or over in ("order", "load") or problem.weighting.wander is not None):
        return True
    both = fit_with_basis(beside, f, best)
    further = _gained(f, both, scale) - chance  # what any shape explains of that which the effect leaves
    left = (f.misfits[0] - problem.size) / scale
    if as_any:
        # if what is left has the effect's own quantity, and nothing else, to depend on, the shape is wrong
        return further <= DEPENDS or (not follows_laws(problem, f) and further < MOSTLY * left)
    # what is unknown depends on something else if this quantity explains hardly any of what the effect leaves; the
    # basis of one order says nothing about another
    if over != "order" and further <= (1.0 - NEARLY_ALL) * left:
        return True
    # if it explains as much with that shape as alone, it does not imitate it: both are there
    return gained > 0.0 and _gained(any_shape, both, scale) >= MOSTLY * gained


def _best_basis(problem: EquationErrorProblem, bare: Fit) -> str | None:
    """The generic basis of a problem that promises most beside a ``bare`` fit; None if none promises anything."""
    return next((name for _, name in screen_generic_bases(problem, bare)), None)


def _gained(before: Fit, after: Fit, scale: float) -> float:
    """Gain of a fit from the torque and from constants closer to their file, in units of the remaining noise.

    Reduced by what the additional numbers gain by chance; for a basis with many columns that soon exceeds 2 %.
    """
    refuse_different_weightings(before, after)
    gained = (before.misfits[0] - after.misfits[0]) / scale + before.prior_cost - after.prior_cost
    return gained - by_chance(len(after.hypothesis.free) - len(before.hypothesis.free))


def _mostly(problem: EquationErrorProblem, f: Fit, bare: Fit) -> bool:
    """Whether most of the encoder difference of a ``bare`` fit is removed."""
    return _of_the_encoders(problem, f) <= (1.0 - MOSTLY) * _of_the_encoders(problem, bare)


def _of_these(f: Fit, rows: slice) -> float:
    """Power of some encoder rows beyond their noise."""
    return max(float(np.sum(f.raw[rows] ** 2)) - (rows.stop - rows.start), 0.0)


def _lines(rows: slice) -> float:
    """Largest such power that interpolation error between encoder lines may leave."""
    return (APART**2 - 1.0) * (rows.stop - rows.start)


def _of_the_encoders(problem: EquationErrorProblem, f: Fit) -> float:
    """Power of the encoder difference beyond its noise; outliers count in full, since an encoder error makes them."""
    return _of_these(f, slice(problem.size, problem.rows))


def _over(problem: EquationErrorProblem, bare: Fit, over: str) -> dict[str, np.ndarray]:
    """The bases over a quantity; for time, one basis for all recordings together."""
    if over == "load":
        return load_bases(problem, bare)
    if over == "order":
        return order_bases(problem, bare)
    found = {name: columns for name, columns in problem.generic_bases.items() if dependence(name) == over}
    if over == "time" and found:
        return {"time#all": np.concatenate([*found.values()], axis=1)}
    return found
