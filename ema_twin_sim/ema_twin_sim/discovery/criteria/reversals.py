"""Reversals: what lies beside standstill is friction that gives way, by a law that no model has exactly.

A machine that goes to and fro over the same way reverses at the same angles, so that what happens there repeats with
the angle as a damaged tooth does.
"""

from __future__ import annotations

import numpy as np

from ...criteria import PART, SMALL
from ...effects import catalogue
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...plant.measured_motion import SPEED


def shows_where_slowest(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an added effect over a shaft's angle explains the slowest of the moving rows and no others.

    Not asked of operating points, most of which stand still.
    """
    if catalogue()[f.hypothesis.added[name].effect].depends_on != "order" or not problem.size:
        return False
    if any(o.of_points for o in problem.observations):
        return False
    less = fit(problem, f.hypothesis.without(name), 6, known=f)
    speed = np.concatenate([np.abs(o.motion[o.rows, SPEED]) for o in problem.observations])
    slowest = speed <= np.quantile(speed, SMALL)
    if slowest.mean() > PART:  # it went at one speed, and was never slow
        return False
    fall = (problem.costs(less.raw) - problem.costs(f.raw))[: problem.size]
    return float(fall[~slowest].sum()) < SMALL * float(fall.sum())
