"""Wandering: the share by which friction wanders, estimated from the residual of a fit."""

from __future__ import annotations

import math

import numpy as np

from ..criteria import CORRELATION, COST_OF_WANDER
from ..plant.motion import SPEED, TIME
from .basis_columns import at_rows, at_rows_of, hat_columns
from .equation import EquationErrorProblem
from .fit import Fit
from .generic_bases import KNOT, KNOTS, LEAST_KNOTS, MOST_KNOTS
from .wander import Wander

SHARES = tuple(0.0025 * 2.0 ** (k / 2.0) for k in range(12))
"""Shares of the friction by which it may wander: from 0.25 % to 11 %."""
HARDLY = 1e-12
"""Relative to the largest squared spread: directions below this are rounding errors."""


def wandering(problem: EquationErrorProblem, f: Fit, *, drifts: bool = False) -> Wander | None:
    """How friction wanders, from the residual of a fit: the most likely share; None if there is no wandering.

    With ``drifts``, friction only drifts over a recording, and turns round at most once.
    """
    columns = _friction_over_time(problem, float(f.predicted.plant["asymmetry"][0]), drifts)
    if columns is None:
        return None
    slopes = f.jacobian[: problem.size]
    known, _ = np.linalg.qr(slopes / np.maximum(np.linalg.norm(slopes, axis=0), 1e-30))
    residual = f.residual[: problem.size]
    residual = residual - known @ (known.T @ residual)
    every = np.zeros((problem.size, sum(c.shape[1] for _, c in columns)))
    at = 0
    for part, c in columns:
        every[part, at : at + c.shape[1]] = c * f.weights[part][:, None]
        at += c.shape[1]
    # remove what the fit's own parameters can explain
    every -= known @ (known.T @ every)
    squared_spreads, axes = np.linalg.eigh(every.T @ every)
    if not squared_spreads[-1] > 0.0:  # no friction that could wander
        return None
    squared_spreads = np.maximum(squared_spreads, HARDLY * squared_spreads[-1])
    spreads = np.sqrt(squared_spreads)
    square, rest = (axes.T @ (every.T @ residual) / spreads) ** 2, float(residual @ residual)
    gains = [_log_likelihood(share, spreads, square, rest, problem.size) for share in (0.0, *SHARES)]
    best = int(np.argmax(gains))
    if best == 0 or gains[best] - gains[0] < COST_OF_WANDER:
        return None
    parts = tuple((part, *np.linalg.svd(c, full_matrices=False)[:2]) for part, c in columns)
    return Wander(SHARES[best - 1], parts, 2.0 * (gains[best] - gains[0]))


def _log_likelihood(share: float, spreads: np.ndarray, square: np.ndarray, rest: float, count: int) -> float:
    """Log-likelihood of a residual with power ``square`` (k,) along some directions and ``rest`` in total.

    Every second row counts as independent; the noise level is the most likely one.
    """
    inflation = 1.0 + (share * spreads) ** 2
    left = rest - float(np.sum(square * (1.0 - 1.0 / inflation)))
    independent = count / CORRELATION
    return -0.5 * independent * math.log(max(left, 1e-300)) - 0.5 * float(np.sum(np.log(inflation)))


def _friction_over_time(
    problem: EquationErrorProblem, asymmetry: float, drifts: bool
) -> list[tuple[slice, np.ndarray]] | None:
    """Per recording: its rows, and columns (m, k), in units of noise, of friction that acts for a while each.

    Friction that differs by direction, by a share ``asymmetry`` of itself, wanders as a whole: part of it then drives
    in one direction and brakes in the other, as a load does.
    """
    moving = [o for o in problem.observations if len(o.rows) and not o.of_points]
    if not moving:
        return None
    speeds = np.concatenate([np.abs(o.motion[o.rows, SPEED]) for o in moving])
    knots = np.unique(np.quantile(speeds, np.linspace(0.0, 1.0, KNOTS)))
    if len(knots) < 2:
        return None
    by_speed = [hat_columns(np.abs(o.motion[:, SPEED]), knots) for o in problem.observations]
    sense = [np.sign(o.motion[:, SPEED])[:, None] for o in problem.observations]
    braking = at_rows(problem, [b * s for b, s in zip(by_speed, sense, strict=True)])[: problem.size]
    # what does not brake in both directions, or accelerates, is not friction
    driving = at_rows(problem, by_speed)[: problem.size]
    accelerating = (problem.acceleration / problem.noise)[:, None]
    slopes = np.concatenate([braking, driving, accelerating], axis=1)
    levels = np.linalg.lstsq(slopes, problem.measured[: problem.size], rcond=1e-6)[0][: len(knots)]
    found = []
    for k, (o, part) in enumerate(zip(problem.observations, problem.torque_parts, strict=True)):
        if not len(o.rows) or o.of_points:
            continue
        lasts = float(o.motion[-1, TIME])
        knots_in_time = LEAST_KNOTS if drifts else min(max(LEAST_KNOTS, round(lasts / KNOT)), MOST_KNOTS)
        times = np.linspace(0.0, lasts, knots_in_time)
        friction = (np.maximum(by_speed[k] @ levels, 0.0))[:, None] * (sense[k] + asymmetry)
        found.append((part, at_rows_of(o, friction * hat_columns(o.motion[:, TIME], times))))
    return found
