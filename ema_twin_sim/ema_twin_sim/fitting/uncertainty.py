"""How sure the numbers of a fit are: what noise and priors leave open, and how far the recordings disagree."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..criteria import FAR_OFF_ROW
from ..identification.uncertainty import blocks, move_without, scaled_inverse
from .misfit import Misfit
from .solver import Solution, priors

RIDGE = 1e-12  # every number of a fit has a prior


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Of what was solved for (k numbers): standard errors (k,) and correlations (k, k)."""

    std: np.ndarray
    correlation: np.ndarray


def weigh(misfit: Misfit, solution: Solution) -> float:
    """Set what a row's variance is from what is left over and from how far the recordings disagree; by what factor.

    White least squares is far too sure of itself, because what is left over is not white: leaving out one recording (or
    one stretch) after the other, linearised, shows how far the numbers really move. Where that is more than rows and
    priors explain, each row is worth less.
    """
    before = misfit.variance
    misfit.variance *= max(1.0, solution.misfit / misfit.rows)
    curvature = np.linalg.inv(_posterior(misfit, solution))
    away = _moves(misfit, solution)
    count = len(away)
    distance = (count - 1) / count * float(np.einsum("bi,ij,bj->", away, curvature, away))
    misfit.variance *= min(max(1.0, distance / away.shape[1]), FAR_OFF_ROW)
    return misfit.variance / before


def uncertainty(misfit: Misfit, solution: Solution) -> Uncertainty:
    """Standard errors: the larger of what curvature and priors tell and of what the recordings show (Tukey's
    jackknife); with it, what each counter's zero leaves open, and what the method itself may be wrong by.
    """
    posterior = _posterior(misfit, solution)
    away = _moves(misfit, solution)
    jackknife = (len(away) - 1) / len(away) * np.sum(away**2, axis=0)
    zeros = _zeros(misfit, solution) @ posterior / misfit.variance
    own = np.sqrt(np.diag(posterior))
    per = np.array([n.slope(v) for n, v in zip(solution.freedom.numbers, solution.values, strict=True)])
    method = misfit.systematic(solution.values) / per
    std = np.sqrt(np.maximum(own**2, jackknife) + np.sum(zeros**2, axis=0) + method**2)
    return Uncertainty(std, posterior / np.outer(own, own))


def _zeros(misfit: Misfit, solution: Solution) -> np.ndarray:
    """The pull (b, k) of each recording's zero: positions count from one noisy sample, and so do angles of effects."""
    weights = misfit.weights(misfit.residual(solution.values))
    shift = misfit.zero_shift(solution.values, weights)
    recordings = 1 + max(recording for recording, _ in misfit.parts)
    pulls = np.zeros((recordings, len(solution.values)))
    for recording, part in misfit.parts:
        pulls[recording] += solution.slopes[part].T @ shift[part]
    return pulls


def left_out(misfit: Misfit, solution: Solution, which: np.ndarray, count: int) -> np.ndarray:
    """What is solved for (b, k), to first order, without each of ``count`` blocks; ``which`` (m,) are the rows' blocks,
    negative where a row stays in.
    """
    x = solved(solution)
    _, inverse = priors(solution.freedom, x)
    noise = math.sqrt(misfit.variance)
    slopes, residual = solution.slopes / noise, solution.residual / noise
    information = slopes.T @ slopes + np.diag(inverse**2)
    return np.array(
        [x + move_without(information, slopes[which == k], residual[which == k], RIDGE) for k in range(count)]
    )


def solved(solution: Solution) -> np.ndarray:
    """What was solved for (k,): the values, some as logarithms."""
    return np.array([n.to_solver(v) for n, v in zip(solution.freedom.numbers, solution.values, strict=True)])


def _moves(misfit: Misfit, solution: Solution) -> np.ndarray:
    """How far each block, left out, moves what is solved for from the mean of all such moves (b, k)."""
    which = blocks(misfit.parts)
    away = left_out(misfit, solution, which, int(which.max()) + 1)
    return away - away.mean(axis=0)


def _posterior(misfit: Misfit, solution: Solution) -> np.ndarray:
    """Covariance (k, k) by curvature and priors."""
    _, inverse = priors(solution.freedom, solved(solution))
    return scaled_inverse(solution.slopes.T @ solution.slopes / misfit.variance + np.diag(inverse**2), RIDGE)
