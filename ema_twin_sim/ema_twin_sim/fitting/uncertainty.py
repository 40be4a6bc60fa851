"""Uncertainty of fitted parameters: from noise and priors, and from the disagreement between recordings."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..criteria import FAR_OFF_ROW
from ..identification.uncertainty import blocks, move_without, scaled_inverse
from .misfit import Misfit
from .solver import Solution, priors

RIDGE = 1e-12  # every parameter of a fit has a prior


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Uncertainty of the solver's variables (k): standard errors (k,) and correlations (k, k)."""

    std: np.ndarray
    correlation: np.ndarray


def weigh(misfit: Misfit, solution: Solution) -> float:
    """Set the row variance from the residual and the disagreement between recordings; return the factor of change.

    White-noise least squares is far too optimistic, because the residual is not white. Leaving out one recording (or
    stretch) after the other, linearised, shows how uncertain the parameters are. If that is more than rows and priors
    explain, each row gets less weight.
    """
    before = misfit.variance
    misfit.variance *= max(1.0, solution.misfit / misfit.rows)
    away = _moves(misfit, solution)
    count = len(away)
    distance = (count - 1) / count * float(np.einsum("bi,ij,bj->", away, _information(misfit, solution), away))
    misfit.variance *= min(max(1.0, distance / away.shape[1]), FAR_OFF_ROW)
    return misfit.variance / before


def uncertainty(misfit: Misfit, solution: Solution) -> Uncertainty:
    """Standard errors of the solver's variables, and their correlations.

    The larger of two estimates (curvature with priors; Tukey's jackknife over recordings), plus the error of each
    counter's zero and the systematic error of the method.
    """
    posterior = scaled_inverse(_information(misfit, solution), RIDGE)
    away = _moves(misfit, solution)
    jackknife = (len(away) - 1) / len(away) * np.sum(away**2, axis=0)
    zeros = _zeros(misfit, solution) @ posterior / misfit.variance
    own = np.sqrt(np.diag(posterior))
    per = np.array([n.slope(v) for n, v in zip(solution.freedom.numbers, solution.values, strict=True)])
    method = misfit.systematic(solution.values) / per
    std = np.sqrt(np.maximum(own**2, jackknife) + np.sum(zeros**2, axis=0) + method**2)
    return Uncertainty(std, posterior / np.outer(own, own))


def _zeros(misfit: Misfit, solution: Solution) -> np.ndarray:
    """Pull (b, k) of each recording's zero: positions, and angles of effects, count from one noisy sample."""
    weights = misfit.weights(misfit.residual(solution.values))
    shift = misfit.zero_shift(solution.values, weights)
    recordings = 1 + max(recording for recording, _ in misfit.parts)
    pulls = np.zeros((recordings, len(solution.values)))
    for recording, part in misfit.parts:
        pulls[recording] += solution.slopes[part].T @ shift[part]
    return pulls


def left_out(misfit: Misfit, solution: Solution, which: np.ndarray, count: int) -> np.ndarray:
    """Solver variables (b, k), to first order, without each of ``count`` blocks.

    ``which`` (m,) is the block of each row, negative if a row is never left out.
    """
    x, information, noise = solved(solution), _information(misfit, solution), math.sqrt(misfit.variance)
    slopes, residual = solution.slopes / noise, solution.residual / noise
    return np.array(
        [x + move_without(information, slopes[which == k], residual[which == k], RIDGE) for k in range(count)]
    )


def solved(solution: Solution) -> np.ndarray:
    """The solver's variables (k,): the values, some as logarithms."""
    return np.array([n.to_solver(v) for n, v in zip(solution.freedom.numbers, solution.values, strict=True)])


def _moves(misfit: Misfit, solution: Solution) -> np.ndarray:
    """Change (b, k) of the solver's variables without each block, relative to the mean of these changes."""
    which = blocks(misfit.parts)
    away = left_out(misfit, solution, which, int(which.max()) + 1)
    return away - away.mean(axis=0)


def _information(misfit: Misfit, solution: Solution) -> np.ndarray:
    """Information (k, k) of rows and priors about the solver's variables."""
    _, inverse = priors(solution.freedom, solved(solution))
    return solution.slopes.T @ solution.slopes / misfit.variance + np.diag(inverse**2)
