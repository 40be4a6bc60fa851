"""Uncertainty of fitted parameters: from the noise, the priors and the disagreement between recordings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..criteria import NEGLIGIBLE
from ..model.roles import FRICTION
from .equation import EquationErrorProblem
from .fit import Fit, prior_rows
from .hypothesis import Hypothesis

STEP_SHARES = (1.0, 0.5, 0.2)
RIDGE = 1e-9  # for parameters of which some have no prior
BLOCKS = 6  # fewest blocks to compare; recordings are split if there are fewer
LEAST_ELSEWHERE = 1e-3  # smallest share of the information about a direction that must come from other blocks


class Linearised(NamedTuple):
    """A fit to first order, in units of the noise: its rows and priors are linear in the free parameters."""

    slopes: np.ndarray  # (m, k), of the rows
    residual: np.ndarray  # (m,)
    priors: np.ndarray  # (p, k), slopes of the priors

    @property
    def information(self) -> np.ndarray:
        """Information (k, k) about the free parameters, from rows and priors."""
        return self.slopes.T @ self.slopes + self.priors.T @ self.priors


def linearised(f: Fit, held: Sequence[int] = (), *, by_torque: bool = False) -> Linearised:
    """A fit to first order; of the parameters with the indices ``held`` its rows show nothing.

    ``by_torque``: its rows are as sure as those of the torque are.
    """
    inflations = np.full(len(f.residual), f.variance_inflations[0]) if by_torque else f.row_variance_inflations
    root_inflation = np.sqrt(inflations)
    slopes = f.jacobian / root_inflation[:, None]
    slopes[:, list(held)] = 0.0
    return Linearised(slopes, f.residual / root_inflation, prior_rows(f.hypothesis)[1])


def blocks(parts: Sequence[tuple[int, slice]]) -> np.ndarray:
    """Block index (m,) of each row: its recording, or a stretch of it if recordings are few.

    ``parts`` are pairs of a recording and rows of it, evenly spread over its time; together they cover all rows.
    """
    pieces = -(-BLOCKS // (1 + max(recording for recording, _ in parts)))
    found = np.zeros(max(part.stop for _, part in parts), int)
    for recording, part in parts:
        count = part.stop - part.start
        found[part] = recording * pieces + (np.arange(count) * pieces) // max(count, 1)
    return found


def covariance(problem: EquationErrorProblem, f: Fit, *, by_torque: bool = False) -> np.ndarray:
    """Covariance (k, k) of the free parameters: curvature and priors, plus the disagreement between blocks of rows.

    ``by_torque``: of parameters that show in the torque alone, however badly the encoders' difference is explained.

    White-noise least squares is far too optimistic because the residual is not white. How far each recording pulls the
    parameters shows how uncertain they are. Open friction that ended at zero would go on to negative values: it has its
    own variance, and the others are as sure as without it. So are they beside what is held without a prior.
    """
    free = _covariance(problem, f, by_torque=by_torque)
    ended = _not_moving(f)
    if not ended:
        return free
    held = _covariance(problem, f, ended, by_torque=by_torque)
    held[ended, ended] = free[ended, ended]
    return held


def _not_moving(f: Fit) -> list[int]:
    """Indices of what is held without a prior, and of open friction that ended at zero."""
    return [
        k
        for k, (free, value) in enumerate(zip(f.hypothesis.free, f.hypothesis.values, strict=True))
        if free.prior is None
        and (free.lower == free.upper or (free.lower == value == 0.0 and free.path.removeprefix("scale.") in FRICTION))
    ]


def _covariance(
    problem: EquationErrorProblem, f: Fit, held: Sequence[int] = (), *, by_torque: bool = False
) -> np.ndarray:
    """Covariance (k, k) with some parameters held at their values, those with the indices ``held``."""
    near = linearised(f, held, by_torque=by_torque)
    found = scaled_inverse(near.information)
    which = blocks(problem.parts)
    # Coefficients of generic bases are not reported, and some of them depend on one block alone. What they can explain
    # is projected out first, in all blocks.
    asked = np.array([not free.path.startswith("basis.") for free in f.hypothesis.free])
    aside, _ = np.linalg.qr(near.slopes[:, ~asked])
    slopes = near.slopes[:, asked] - aside @ (aside.T @ near.slopes[:, asked])
    residual = near.residual - aside @ (aside.T @ near.residual)
    found[np.ix_(asked, asked)] += disagreement(slopes, residual, near.priors[:, asked], which)
    return _within_ranges(found, f)


def _within_ranges(spread: np.ndarray, f: Fit) -> np.ndarray:
    """Covariance (k, k), limited for shares, which lie between two bounds: no share is 1 ± 1.7.

    A uniform prior between the bounds has a variance of one twelfth of their distance squared.
    """
    for k, free in enumerate(f.hypothesis.free):
        p = f.hypothesis.parameter_of(free.path)
        if p is not None and p.unit == "1" and math.isfinite(p.upper - p.lower):
            spread = spread - np.outer(spread[:, k], spread[k]) / (spread[k, k] + (p.upper - p.lower) ** 2 / 12.0)
    return spread


def disagreement(jacobian: np.ndarray, residual: np.ndarray, priors: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Covariance (k, k) from the disagreement of blocks ``which`` (m,) of rows, for any correlation within a block.

    ``jacobian`` (m, k) and ``residual`` (m,) are weighted, ``priors`` (p, k) are the slopes of prior rows. A block
    pulls the fit towards itself, so its residuals are smaller than its noise. They are scaled by the inverse root of
    one minus its leverage (CR2 of Bell and McCaffrey, Survey Methodology 28, 2002). A jackknife would overestimate the
    error by a factor of two or three where one short recording alone determines a parameter.
    """
    known = scaled_inverse(jacobian.T @ jacobian + priors.T @ priors)
    root = np.linalg.cholesky(known)
    found = np.zeros_like(known)
    for k in np.unique(which):
        rows = jacobian[which == k] @ root
        leverage, directions = np.linalg.eigh(rows.T @ rows)
        pull = directions.T @ (rows.T @ residual[which == k])
        move = root @ (directions @ (pull / np.sqrt(np.maximum(1.0 - leverage, LEAST_ELSEWHERE))))
        found += np.outer(move, move)
    return found


def held_out(problem: EquationErrorProblem, f: Fit) -> tuple[list[np.ndarray], np.ndarray]:
    """Parameters (k,) to judge each recording by, and the residual (m,) that they leave in it.

    They are fitted, to first order, to all other recordings; if there is no other, they are those of the fit.
    """
    h, left = f.hypothesis, problem.residual(problem.predict(f.hypothesis, side_by_side=True))
    if len(problem.observations) == 1:
        return [h.values], left
    # The tooth contact is no finding, and linearising through impacts is unreliable: keep the value from all
    # recordings, as that of what is held. Nothing else may move as if these made up for it.
    still = [k for k, free in enumerate(h.free) if free.path.startswith("contact.") or free.lower == free.upper]
    near = linearised(f, still)
    information, (lower, upper) = near.information, problem.bounds(h)
    # Others that tell hardly anything of an open constant, such as friction at one speed alone, would throw it far off;
    # what an effect explains in a recording is never told by that recording itself.
    unknown = np.array([free.path.startswith("scale.") and free.prior is None for free in h.free], bool)
    known = np.where(np.outer(unknown, unknown), NEGLIGIBLE * information, 0.0)

    def cost(trial: Hypothesis, residual: np.ndarray, others: np.ndarray) -> float:
        pr, _ = prior_rows(trial)
        return float((problem.costs(residual) / f.row_variance_inflations)[others].sum()) + float(pr @ pr)

    unmoved, found = left.copy(), []
    for t, e in zip(problem.torque_parts, problem.encoder_parts, strict=True):
        rows = np.r_[t, e]
        step = move_without(information + known, near.slopes[rows], near.residual[rows])
        others = np.ones(problem.rows, bool)
        others[rows] = False
        # A first-order step may be far too long if one recording dominates: use the fraction that is best for the
        # others.
        best, least = h, cost(h, unmoved, others)
        for share in STEP_SHARES:
            trial = h.at(np.clip(h.values + share * step, lower, upper))
            residual = problem.residual(problem.predict(trial, side_by_side=True))
            if (now := cost(trial, residual, others)) < least:
                best, least, left[rows] = trial, now, residual[rows]
        found.append(best.values)
    return found, left


def move_without(information: np.ndarray, slopes: np.ndarray, residual: np.ndarray, ridge: float = RIDGE) -> np.ndarray:
    """First-order change (k,) of a solution if some rows are left out.

    ``information`` (k, k) is that of all rows and priors; ``slopes`` (m, k) and ``residual`` (m,) of the rows are in
    units of the noise.
    """
    return -scaled_inverse(information - slopes.T @ slopes, ridge) @ (slopes.T @ residual)


def scaled_inverse(a: np.ndarray, ridge: float = RIDGE) -> np.ndarray:
    """Inverse of an information matrix (k, k), with its rows scaled first.

    ``ridge`` is the minimum information of a direction. A direction that nothing determines, or that rounding made
    negative, is then uncertain and does not raise an error.
    """
    size = np.diag(a).copy()
    size = np.sqrt(np.where(size > 0.0, size, 1.0))
    scaled = a / np.outer(size, size)
    known, directions = np.linalg.eigh(0.5 * (scaled + scaled.T))
    return (directions / np.maximum(known, ridge)) @ directions.T / np.outer(size, size)
