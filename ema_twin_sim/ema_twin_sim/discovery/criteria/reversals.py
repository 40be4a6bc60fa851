"""Reversals: residuals near standstill come from presliding friction, which no model describes exactly.

A machine that moves back and forth over the same range reverses at the same angles. What happens there repeats with the
angle, as a damaged tooth does.
"""

from __future__ import annotations

import math

import numpy as np

from ...criteria import PART, SMALL
from ...effects import catalogue
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...plant.motion import SPEED, TIME


def shows_where_slowest(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an added effect over a shaft angle explains only the slowest of the moving rows.

    Not tested for operating points, most of which stand still. Not tested either for a wave so fine that whole cycles
    pass while the machine is slow: only slow motion shows what smoothing hides at higher speeds.
    """
    instance = f.hypothesis.added[name]
    if catalogue()[instance.effect].depends_on != "order" or "order" not in instance.options or not problem.size:
        return False
    if any(o.of_points for o in problem.observations):
        return False
    speed = np.concatenate([np.abs(o.motion[o.rows, SPEED]) for o in problem.observations])
    limit = float(np.quantile(speed, SMALL))
    slowest = speed <= limit
    if slowest.mean() > PART:  # it ran at one speed and was never slow
        return False
    if f.hypothesis.model().motor_order(name) * _way_when_slow(problem, limit) >= 2.0 * math.pi:
        return False
    less = fit(problem, f.hypothesis.without(name), 6, known=f)
    fall = (problem.costs(less.raw) - problem.costs(f.raw))[: problem.size]
    return float(fall[~slowest].sum()) < SMALL * float(fall.sum())


def _way_when_slow(problem: EquationErrorProblem, limit: float) -> float:
    """How far [rad] the motor turns, on average, each time it stays at or below a speed limit [rad/s]."""
    way, times = 0.0, 0
    for o in problem.observations:
        speed, step = np.abs(o.motion[:, SPEED]), np.diff(o.motion[:, TIME], prepend=o.motion[0, TIME])
        slow = speed <= limit
        way += float(speed[slow] @ step[slow])
        times += int(slow[0]) + int(np.count_nonzero(slow[1:] & ~slow[:-1]))
    return way / max(times, 1)
