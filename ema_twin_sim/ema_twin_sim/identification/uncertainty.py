"""How sure the numbers of a fit are: what the noise, the priors and the recordings' own disagreement leave open."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .equation import EquationErrorProblem
from .fit import Fit, prior_rows

STEP_SHARES = (1.0, 0.5, 0.2, 0.0)
RIDGE = 1e-9  # of numbers of which some have no prior
BLOCKS = 6  # fewest blocks that are held against each other; recordings are parted where there are fewer
LEAST_ELSEWHERE = 1e-3  # share of what is known of a number that comes from other blocks, where hardly any does


def blocks(parts: Sequence[tuple[int, slice]]) -> np.ndarray:
    """The block (m,) that each row belongs to: its recording, or a stretch of it where recordings are few.

    ``parts`` are a recording and rows of it, evenly spread over its time; together they are all rows.
    """
    pieces = -(-BLOCKS // (1 + max(recording for recording, _ in parts)))
    found = np.zeros(max(part.stop for _, part in parts), int)
    for recording, part in parts:
        count = part.stop - part.start
        found[part] = recording * pieces + (np.arange(count) * pieces) // max(count, 1)
    return found


def covariance(problem: EquationErrorProblem, f: Fit) -> np.ndarray:
    """Covariance (k, k) of the free numbers: curvature and priors, and what blocks of rows disagree by on top.

    White least squares is far too sure of itself, because what is left over is not white: how each recording pulls the
    numbers shows how far they really move.
    """
    _, pj = prior_rows(f.hypothesis)
    root_inflation = np.sqrt(f.row_variance_inflations)
    scaled = f.jacobian / root_inflation[:, None]
    found = scaled_inverse(scaled.T @ scaled + pj.T @ pj)
    which = blocks(problem.parts)
    # a generic basis's numbers are asked for by nobody, and some of them stand on one block alone: whatever it can do
    # is set aside first, in all blocks
    asked = np.array([not free.path.startswith("basis.") for free in f.hypothesis.free])
    aside, _ = np.linalg.qr(scaled[:, ~asked])
    jacobian = scaled[:, asked] - aside @ (aside.T @ scaled[:, asked])
    residual = f.residual / root_inflation
    residual = residual - aside @ (aside.T @ residual)
    pj = pj[:, asked]
    found[np.ix_(asked, asked)] += disagreement(jacobian, residual, pj, which)
    return _within_ranges(found, f)


def _within_ranges(spread: np.ndarray, f: Fit) -> np.ndarray:
    """Covariance (k, k) beside what is known of a share, which is somewhere between its ends: no share is 1 ± 1.7.

    Any value between two ends is as likely, with a variance of a twelfth of their distance squared.
    """
    for k, free in enumerate(f.hypothesis.free):
        p = f.hypothesis.parameter_of(free.path)
        if p is not None and p.unit == "1" and math.isfinite(p.upper - p.lower):
            spread = spread - np.outer(spread[:, k], spread[k]) / (spread[k, k] + (p.upper - p.lower) ** 2 / 12.0)
    return spread


def disagreement(jacobian: np.ndarray, residual: np.ndarray, priors: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Covariance (k, k) that the blocks ``which`` (m,) of rows show, whatever correlates the rows of one block.

    ``jacobian`` (m, k) and ``residual`` (m,) are weighted, ``priors`` (p, k) are the slopes of prior rows. A block
    draws the fit to itself, so that its residuals are smaller than its noise. They are raised by the inverse root of
    one less its leverage (CR2 of Bell and McCaffrey, Survey Methodology 28, 2002): where one short recording alone
    shows a number, a jackknife makes its error two or three times as large as it is.
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


def held_out(problem: EquationErrorProblem, f: Fit) -> list[np.ndarray]:
    """The free numbers (k,) that each recording is judged by: fitted, to first order, to all the others."""
    _, pj = prior_rows(f.hypothesis)
    root_inflation = np.sqrt(f.row_variance_inflations)
    jacobian, residual_here = f.jacobian / root_inflation[:, None], f.residual / root_inflation
    information = jacobian.T @ jacobian + pj.T @ pj
    lower, upper = problem.bounds(f.hypothesis)
    # how teeth meet is no finding, and a line through impacts leads anywhere: it stays as all recordings have it
    moving = np.array([not free.path.startswith("contact.") for free in f.hypothesis.free])
    found = []
    for t, e in zip(problem.torque_parts, problem.encoder_parts, strict=True):
        rows = np.r_[t, e]
        step = move_without(information, jacobian[rows], residual_here[rows]) * moving
        others = np.ones(problem.rows, bool)
        others[rows] = False
        # to first order a step may be far too long, where one recording knows most: as much of it as the others gain by
        best, least = f.hypothesis.values, np.inf
        for share in STEP_SHARES:
            values = np.clip(f.hypothesis.values + share * step, lower, upper)
            trial = f.hypothesis.at(values)
            residual = problem.residual(problem.predict(trial, side_by_side=True))
            pr, _ = prior_rows(trial)
            cost = float((problem.costs(residual) / root_inflation**2)[others].sum()) + float(pr @ pr)
            if cost < least:
                best, least = values, cost
        found.append(best)
    return found


def move_without(information: np.ndarray, slopes: np.ndarray, residual: np.ndarray, ridge: float = RIDGE) -> np.ndarray:
    """How far (k,) a solution moves, to first order, where some rows are left out.

    ``information`` (k, k) is that of all rows and of the priors; the rows' ``slopes`` (m, k) and ``residual`` (m,) are
    in units of the noise.
    """
    return -scaled_inverse(information - slopes.T @ slopes, ridge) @ (slopes.T @ residual)


def scaled_inverse(a: np.ndarray, ridge: float = RIDGE) -> np.ndarray:
    """The inverse of an information matrix (k, k), its rows scaled first.

    ``ridge`` is the least that a direction is known by, so that what nothing holds, or what rounding has made less than
    nothing, is uncertain and no error.
    """
    size = np.diag(a).copy()
    size = np.sqrt(np.where(size > 0.0, size, 1.0))
    scaled = a / np.outer(size, size)
    known, directions = np.linalg.eigh(0.5 * (scaled + scaled.T))
    return (directions / np.maximum(known, ridge)) @ directions.T / np.outer(size, size)
