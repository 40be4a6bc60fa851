"""Own shape: whether an effect explains what any dependence on the same quantity would, beside something unknown.

Where something is left that no effect explains, an effect that was found may be nothing but its likeness: a bump of
friction over the speed looks like Stribeck's. Then a basis of any shape over that quantity explains much more than the
effect does. Where the effect's own shape explains what the basis explains, it is that effect, whatever else is left.

An encoder that is late or errs shows in the encoders' difference alone, and takes most of it away: what takes a part of
it beside something unknown is the likeness of lines that are interpolated, or of a gearbox that rings.
"""

from __future__ import annotations

import numpy as np

from ...criteria import MOSTLY, NEGLIGIBLE
from ...effects import catalogue
from ...identification.comparable import refuse_different_weightings
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.generic_bases import dependence, load_bases, order_bases
from ...identification.screening import screen_generic_bases
from .worth import ENCODER_ONLY


def by_own_shape(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """The added effects that explain what they do by their own shape; also those over what there is no basis for."""
    return tuple(name for name in f.hypothesis.added if _own(problem, f, name))


def _own(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    over = catalogue()[f.hypothesis.added[name].effect].depends_on
    bare = fit(problem, f.hypothesis.without(name), 6, known=f)
    if f.hypothesis.added[name].effect in ENCODER_ONLY:
        left = 1.0 - MOSTLY
        return _of_the_encoders(problem, f) <= left * _of_the_encoders(problem, bare)
    shapes = _over(problem, bare, over)
    if not shapes:  # of what shows over this, there is no other shape
        return True
    refuse_different_weightings(bare, f)
    took = bare.misfit - f.misfit
    if took < NEGLIGIBLE * f.judged:
        return False
    beside = problem.with_generic_bases(shapes)
    best = next((found for _, found in screen_generic_bases(beside, bare)), None)
    if best is None:
        return True
    any_shape = fit(beside, bare.hypothesis.with_generic_basis(best, shapes[best].shape[1]), 3, known=bare)
    return took >= (1.0 - NEGLIGIBLE) * (bare.misfit - any_shape.misfit)


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
