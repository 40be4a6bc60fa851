"""Own shape: whether an effect explains what any dependence on the same quantity would, beside something unknown.

Where something is left that no effect explains, an effect that was found may be nothing but its likeness: a bump of
friction over the speed looks like Stribeck's. Then a basis of any shape over that quantity explains much more than the
effect does. Where the effect's own shape explains what the basis explains, it is that effect, whatever else is left.

An encoder that errs shows in the encoders' difference alone, and takes most of it away: what takes a part of it beside
something unknown is the likeness of lines that are interpolated. One that is late is told from a gearbox that winds up
by what it explains beside the torque that does so.
"""

from __future__ import annotations

import numpy as np

from ...criteria import DEPENDS, MOSTLY, NEGLIGIBLE, SMALL
from ...effects import catalogue
from ...identification.comparable import refuse_different_weightings
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.generic_bases import dependence, fit_with_basis, load_bases, order_bases
from ...identification.screening import screen_generic_bases
from ...identification.sensors import delay_beside_gearbox
from .worth import ENCODER_ONLY


def by_own_shape(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """The added effects that explain what they do by their own shape; also those over what there is no basis for."""
    return tuple(name for name in f.hypothesis.added if _own(problem, f, name))


def _own(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    effect = catalogue()[f.hypothesis.added[name].effect]
    over = effect.depends_on
    if effect.delays and not f.parted:
        alone, beside_gearbox = delay_beside_gearbox(problem, f)
        return beside_gearbox > max(DEPENDS, SMALL * alone)
    bare = fit(problem, f.hypothesis.without(name), 6, known=f)
    if effect.id in ENCODER_ONLY:
        left = 1.0 - MOSTLY
        return _of_the_encoders(problem, f) <= left * _of_the_encoders(problem, bare)
    shapes = _over(problem, bare, over)
    if not shapes:  # of what shows over this, there is no other shape
        return True
    refuse_different_weightings(bare, f)
    took = bare.misfits[0] - f.misfits[0]
    # where friction wanders, neighbouring rows are alike for long: any slow shape gains a little by that
    if took < max(DEPENDS * f.temperatures[0], NEGLIGIBLE * f.judged[0]):
        return False
    beside = problem.with_generic_bases(shapes)
    best = next((found for _, found in screen_generic_bases(beside, bare)), None)
    if best is None:
        return True
    any_shape = fit_with_basis(beside, bare, best)
    return took >= (1.0 - NEGLIGIBLE) * (bare.misfits[0] - any_shape.misfits[0])


def _of_the_encoders(problem: EquationErrorProblem, f: Fit) -> float:
    """Misfit of the encoders' difference beyond its noise."""
    return max(float(problem.costs(f.raw)[problem.size :].sum()) - (problem.rows - problem.size), 0.0)


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
