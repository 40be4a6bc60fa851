"""Own shape: whether an effect explains what any dependence on the same quantity would, beside something unknown.

Where something is left that no effect explains, an effect that was found may be nothing but its likeness: a bump of
friction over the speed looks like Stribeck's. Then a basis of any shape over that quantity explains much more than the
effect does. Where the effect's own shape explains what the basis explains, it is that effect, whatever else is left.

An encoder that errs shows in the encoders' difference alone, and takes most of it away: what takes a part of it beside
something unknown is the likeness of lines that are interpolated. One that is late is told from a gearbox that winds up
by what it explains beside the torque that does so.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...criteria import APART, DEPENDS, INTERPOLATED, MISFIT_DOUBTED, MISFIT_LEFT, MOSTLY, NEARLY_ALL
from ...effects import catalogue
from ...identification.comparable import by_chance, refuse_different_weightings
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.generic_bases import dependence, fit_with_basis, load_bases, order_bases
from ...identification.hypothesis import COMPLIANT_EFFECTS
from ...identification.screening import screen_generic_bases
from ...identification.sensors import delay_shows
from .worth import ENCODER_ONLY, is_lacked

TEETH_STEPS = 8
"""Iterations of a fit: the teeth begin where play had them."""


def by_own_shape(problem: EquationErrorProblem, f: Fit, names: Iterable[str] | None = None) -> tuple[str, ...]:
    """Of the added effects, or of these, those that explain what they do by their own shape.

    Also those that act over a quantity for which there is no basis.
    """
    return tuple(name for name in (f.hypothesis.added if names is None else names) if _own(problem, f, name))


def parts_the_encoders(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether play, a spring, or an encoder's angle error explains how the encoders part, whatever else is left.

    A spring or an angle error must explain most of it, and leave no more than an encoder's lines may: an encoder that
    errs between its lines does so beside a gearbox that gives way, too; its likeness, a spring in the place of play,
    leaves much more where the output is thrown. What play leaves in any recording must be little beside that, since
    what is thrown against its teeth leaves more than lines do. Not so of a late encoder, which a gearbox that winds up
    looks like.
    """
    effect = catalogue()[f.hypothesis.instance(name).effect]
    if effect.id not in {*COMPLIANT_EFFECTS, *ENCODER_ONLY} or effect.delays:
        return False
    parts = [part for part in problem.encoder_parts if part.stop > part.start]
    bare = fit(problem, f.hypothesis.without(name))
    if is_play(f, name):
        parted = _of_the_encoders(problem, bare) / (problem.rows - problem.size)
        if parted <= INTERPOLATED**2:  # as little as that, a spring or lines part them too
            return False
        little = (1.0 - NEARLY_ALL) * parted
        return all(_of_these(f, part) <= little * (part.stop - part.start) for part in parts)
    return all(_of_these(f, part) <= _lines(part) for part in parts) and _mostly(problem, f, bare)


def explains_the_torque(f: Fit, name: str) -> bool:
    """Whether much is left of the torque without an effect, and next to nothing with it.

    A gearbox that winds up draws such effects only so far as they resemble it: what they leave of it shows.
    """
    problem = f.problem
    bare = fit(problem, f.hypothesis.without(name))
    without, beside = (one.misfits[0] / max(problem.size, 1) for one in (bare, f))
    return without > MISFIT_LEFT and beside <= MISFIT_DOUBTED


def is_play(f: Fit, name: str) -> bool:
    """Whether an added effect is play: what lets the encoders part has a width."""
    effect = catalogue()[f.hypothesis.instance(name).effect]
    return effect.id in COMPLIANT_EFFECTS and effect.parameters[0].unit == "rad"


def only_teeth(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether play's teeth alone, without its width, explain a good part of how the encoders part as play does.

    They wind up as a spring does, and with a width besides they take up what is left of a spring beside such errors.
    """
    width = catalogue()[f.hypothesis.instance(name).effect].parameters[0]
    teeth = fit(problem, f.hypothesis.holding({f"effects.{name}.{width.name}": 0.0}), TEETH_STEPS)
    return not _mostly(problem, f, teeth)


def _own(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    effect = catalogue()[f.hypothesis.added[name].effect]
    over = effect.depends_on
    if effect.delays and not f.parted:
        return delay_shows(problem, f)
    bare = fit(problem, f.hypothesis.without(name), 6, known=f)
    if effect.id in ENCODER_ONLY:
        return _mostly(problem, f, bare)
    shapes = _over(problem, bare, over)
    if not shapes:  # of what shows over this, there is no other shape
        return True
    refuse_different_weightings(bare, f)
    took = bare.misfits[0] - f.misfits[0]
    if took < DEPENDS * f.variance_inflations[0]:
        return False
    beside = problem.with_generic_bases(shapes)
    best = next((found for _, found in screen_generic_bases(beside, bare)), None)
    if best is None:
        return True
    any_shape = fit_with_basis(beside, bare, best)
    scale = f.variance_inflations[0]
    gained_by_any = _gained(bare, any_shape, scale, hidden=1 if over == "order" else 0)
    gained = _gained(bare, f, scale)
    # what every machine has is there, as little as its law may fit where it warms up or wanders
    share = MOSTLY if is_lacked(f.hypothesis, effect.id) else NEARLY_ALL
    if gained >= share * gained_by_any:
        return True
    # what explains as much beside that shape as it does alone is no likeness of it: both are there
    return gained > 0.0 and _gained(any_shape, fit_with_basis(beside, f, best), scale) >= MOSTLY * gained


def _gained(before: Fit, after: Fit, scale: float, hidden: int = 0) -> float:
    """What a fit gains by the torque and by constants that come nearer to their file, in units of what is left.

    Less what its numbers gain by chance: of a basis, which has many, that is soon more than two per cent. ``hidden``
    numbers were chosen before the fit, as the order of a wave is: the one that the residual shows most.
    """
    refuse_different_weightings(before, after)
    gained = (before.misfits[0] - after.misfits[0]) / scale + before.prior_cost - after.prior_cost
    return gained - by_chance(len(after.hypothesis.free) - len(before.hypothesis.free) + hidden)


def _mostly(problem: EquationErrorProblem, f: Fit, bare: Fit) -> bool:
    """Whether most of how the encoders part beside a ``bare`` fit is gone."""
    return _of_the_encoders(problem, f) <= (1.0 - MOSTLY) * _of_the_encoders(problem, bare)


def _of_these(f: Fit, rows: slice) -> float:
    """Power of some of the encoders' rows beyond their noise."""
    return max(float(np.sum(f.raw[rows] ** 2)) - (rows.stop - rows.start), 0.0)


def _lines(rows: slice) -> float:
    """The same of an encoder that errs between its lines as far as one may."""
    return (APART**2 - 1.0) * (rows.stop - rows.start)


def _of_the_encoders(problem: EquationErrorProblem, f: Fit) -> float:
    """Power of the encoders' difference beyond its noise, far rows in full: they are what an encoder's error makes."""
    return _of_these(f, slice(problem.size, problem.rows))


def _over(problem: EquationErrorProblem, bare: Fit, over: str) -> dict[str, np.ndarray]:
    """The bases over a quantity; over the time one for all recordings together."""
    if over == "load":
        return load_bases(problem, bare)
    if over == "order":
        return order_bases(problem, bare)
    found = {name: columns for name, columns in problem.generic_bases.items() if dependence(name) == over}
    if over == "time" and found:
        return {"time#all": np.concatenate([*found.values()], axis=1)}
    return found
