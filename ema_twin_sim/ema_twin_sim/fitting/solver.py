"""Levenberg-Marquardt with bounds, priors and down-weighted outliers: the values that minimise a misfit."""

from __future__ import annotations

import math
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from functools import cache

import numpy as np

from ema_bench_replay.errors import InputError

from .free_parameters import FreeParameters
from .misfit import Misfit

ITERATIONS = 15  # steps before the parts are weighted again
TRIES = 6  # damped steps before a fit gives up
ENOUGH = 0.1  # decrease of the cost, in units of noise, below which a fit ends
FINAL, ROUGH = 1e-4, 3e-3  # the same as a share of the cost: for a result, and for a start of another method
STEEPEST = 1e100  # larger slopes belong to a stiffness that no step resolves
PASSES = 3  # times that the parts are weighted again


@dataclass(frozen=True, eq=False)
class Solution:
    """The best values (k,) and the weighted residual (m,).

    ``cost`` is in units of ``misfit.variance`` and includes the priors; ``misfit`` has neither.
    """

    freedom: FreeParameters
    values: np.ndarray
    residual: np.ndarray
    differentiate: Callable[[], np.ndarray]  # returns the slopes; the same at every call
    misfit: float
    cost: float
    ended: bool  # no further step gains anything

    @property
    def slopes(self) -> np.ndarray:
        """Weighted slopes (m, k) in the solver's variables; computed on first use, as most solutions are only compared.

        They are those under the weighting of the parts that the solution was found under.
        """
        return self.differentiate()


def solve(
    misfit: Misfit,
    start: np.ndarray,
    *,
    enough: float = FINAL,
    progress: Callable[[str], None] = lambda text: None,
) -> Solution:
    """Values with the smallest misfit near ``start`` (k,); the parts are weighted again until that changes little."""
    for _ in range(PASSES):
        solution = _descend(misfit, start, ITERATIONS, enough, progress)
        start = solution.values
        if not misfit.reweigh(misfit.residual(start)) and solution.ended:
            break
    return solution


def refine(misfit: Misfit, start: np.ndarray, iterations: int) -> Solution:
    """A few steps from ``start`` with the weighting of the parts fixed, so that costs can be compared."""
    return _descend(misfit, start, iterations, ROUGH, lambda text: None)


def priors(freedom: FreeParameters, solved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(residuals (k,), inverse standard deviations (k,)) of the priors."""
    means, stds = np.array([number.solver_prior for number in freedom.numbers]).T
    return (means - solved) / stds, 1.0 / stds


def _descend(
    misfit: Misfit, start: np.ndarray, iterations: int, enough: float, progress: Callable[[str], None]
) -> Solution:
    held = copy(misfit)  # with its weighting of the parts, under which slopes are computed on demand
    numbers = misfit.freedom.numbers
    lower, upper = np.array([n.solved_bounds for n in numbers]).T

    def out(solved: np.ndarray) -> np.ndarray:
        return np.array([n.from_solver(v) for n, v in zip(numbers, solved, strict=True)])

    def slopes_at(values: np.ndarray, weights: np.ndarray) -> Callable[[], np.ndarray]:
        per = np.array([n.slope(v) for n, v in zip(numbers, values, strict=True)])
        return cache(lambda: np.clip(held.slopes(values, weights) * per, -STEEPEST, STEEPEST))

    x = np.clip([n.to_solver(v) for n, v in zip(numbers, start, strict=True)], lower, upper)
    values = out(x)
    raw = misfit.residual(values)
    known, inverse = priors(misfit.freedom, x)
    plain = misfit.cost(raw)
    cost = plain / misfit.variance + float(known @ known)
    damping = 0.0
    ended = False
    for turn in range(iterations + 1):
        weights = misfit.weights(raw)
        residual, differentiate = raw * weights, slopes_at(values, weights)
        if ended or turn == iterations:
            break
        slopes = differentiate()
        # rows are in units of the noise allowed for each part; outliers count less
        progress(f"round {turn + 1}: misfit {math.sqrt(plain / misfit.rows):.3g} times the noise allowed for")
        curvature = slopes.T @ slopes / misfit.variance + np.diag(inverse**2)
        downhill = slopes.T @ residual / misfit.variance + inverse * known
        # parameters held at a bound that they push against
        loose = np.flatnonzero(~(((x <= lower) & (downhill < 0.0)) | ((x >= upper) & (downhill > 0.0))))
        scale = np.sqrt(np.diag(curvature)[loose])
        normal = curvature[np.ix_(loose, loose)] / np.outer(scale, scale)
        for _ in range(TRIES):
            step = np.zeros(len(x))
            lhs = normal + (damping + 1e-12) * np.eye(len(loose))
            step[loose] = np.linalg.solve(lhs, downhill[loose] / scale) / scale
            trial = np.clip(x + step, lower, upper)
            try:
                trial_raw = misfit.residual(out(trial))
                trial_known, _ = priors(misfit.freedom, trial)
                trial_plain = misfit.cost(trial_raw)
                trial_cost = trial_plain / misfit.variance + float(trial_known @ trial_known)
            except InputError:  # no model exists for these values, or it cannot be simulated
                trial_cost = math.inf
            if trial_cost < cost:
                break
            damping = max(10.0 * damping, 1e-3)
        else:
            ended = True
            break
        fall = cost - trial_cost
        x, values, raw, known, plain, cost = trial, out(trial), trial_raw, trial_known, trial_plain, trial_cost
        damping = 0.1 * damping if damping > 1e-5 else 0.0
        ended = fall < ENOUGH + enough * cost
    return Solution(misfit.freedom, values, residual, differentiate, plain, cost, ended)
