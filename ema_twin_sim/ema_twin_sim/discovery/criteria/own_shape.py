"""Own shape: whether an effect explains what any dependence on the same quantity would, beside something unknown.

Where something is left that no effect explains, an effect that was found may be nothing but its likeness: a bump of
friction over the speed looks like Stribeck's. Then a basis of any shape over that quantity explains much more than the
effect does. Where the effect's own shape explains what the basis explains, it is that effect, whatever else is left.

An encoder that is late or errs shows in the encoders' difference alone, and takes most of it away: what takes a part of
it beside something unknown is the likeness of lines that are interpolated, or of a gearbox that rings.
"""

from __future__ import annotations

import numpy as np

from ...effects import catalogue
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.generic_bases import dependence, order_bases
from ...identification.screening import screen_generic_bases
from .worth import ENCODER_ONLY

TELLING = 0.03  # of the noise's variance: what an effect must take away for its shape to tell anything
OF_ENCODERS = 0.75  # of how the encoders part: eleven true ones took 0.89 or more, three false ones 0.60 or less
OWN_SHARE = 0.98  # of the misfit that the best basis takes away, which an effect must take away


def by_own_shape(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """The added effects that explain what they do by their own shape; also those over what there is no basis for."""
    return tuple(name for name in f.hypothesis.added if _own(problem, f, name))


def _own(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    over = catalogue()[f.hypothesis.added[name].effect].depends_on
    bare = fit(problem, f.hypothesis.without(name), 6, known=f)
    kept = problem.generic_bases
    if f.hypothesis.added[name].effect in ENCODER_ONLY:
        left = 1.0 - OF_ENCODERS
        return _of_the_encoders(problem, f) <= left * _of_the_encoders(problem, bare)
    try:
        problem.generic_bases = _over(problem, bare, over)
        if not problem.generic_bases:  # of what shows over this, there is no other shape
            return True
        took = bare.misfit - f.misfit
        if took < TELLING * f.judged:
            return False
        best = next((found for _, found in screen_generic_bases(problem, bare)), None)
        if best is None:
            return True
        any_shape = fit(
            problem, bare.hypothesis.with_generic_basis(best, problem.generic_bases[best].shape[1]), 3, known=bare
        )
        return took >= OWN_SHARE * (bare.misfit - any_shape.misfit)
    finally:
        problem.generic_bases = kept


def _of_the_encoders(problem: EquationErrorProblem, f: Fit) -> float:
    """Misfit of the encoders' difference beyond its noise."""
    return max(float(problem.costs(f.raw)[problem.size :].sum()) - (problem.rows - problem.size), 0.0)


def _over(problem: EquationErrorProblem, bare: Fit, over: str) -> dict[str, np.ndarray]:
    """The bases over a quantity; over the time one for all recordings together."""
    if over == "order":
        return order_bases(problem, bare)
    found = {name: columns for name, columns in problem.generic_bases.items() if dependence(name) == over}
    if over == "time" and found:
        return {"time#all": np.concatenate([*found.values()], axis=1)}
    return found
