"""Recordings that contradict each other: one alone would need far more friction, or inertia, than the others."""

from __future__ import annotations

import numpy as np

from ...criteria import APART, PART, SMALL
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...model.roles import DRY_FRICTION, VISCOUS_FRICTION

CONSTANTS = {
    "inertia": "scale.inertia",
    "viscous friction": f"scale.{VISCOUS_FRICTION}",
    "dry friction": f"scale.{DRY_FRICTION}",
}


def contradictions(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """One sentence for each recording that seems to come from another machine than the others.

    For each recording, to first order: by what share would it alone change inertia and friction? The reference is the
    median over all recordings. A constant is not reported if it explains little of that recording's error: with
    backlash, in slow motion, inertia hardly shows and absorbs whatever impacts leave.
    """
    places = {free.path: k for k, free in enumerate(f.hypothesis.free)}
    columns = {name: places[path] for name, path in CONSTANTS.items() if path in places}
    if len(problem.observations) < 2 or not columns:
        return ()
    scale = f.variance_inflation
    # The scale parameters multiply the file's values, which are only guesses for open constants.
    guessed = np.array([free.prior is None for free in f.hypothesis.free])
    of_a_share = f.jacobian * np.where(guessed, f.hypothesis.values, 1.0)
    moves, errors, explain = [], [], []
    for part in problem.torque_parts:
        slopes = of_a_share[part][:, [*columns.values()]]
        covariance = np.linalg.inv(slopes.T @ slopes / scale + np.eye(len(columns)) / 0.5**2)
        moves.append(covariance @ (slopes.T @ f.residual[part]) / scale)
        errors.append(np.sqrt(np.diag(covariance)))
        explain.append([_explains(slopes, k, f.residual[part]) for k in range(len(columns))])
    away = np.array(moves) - np.median(moves, axis=0)
    found = []
    for o, shares, sure, taken in zip(problem.observations, away, errors, explain, strict=True):
        for name, share, error, gain in zip(columns, shares, sure, taken, strict=True):
            if abs(share) > max(SMALL, APART * error) and gain > PART:
                more = "more" if share > 0.0 else "less"
                found.append(
                    f"{o.name}: needs {abs(share):.0%} {more} {name} than the other recordings do; it may be of "
                    "another machine, or of one in another state (then judge it alone), or show what no effect explains"
                )
    return tuple(found)


def _explains(slopes: np.ndarray, which: int, residual: np.ndarray) -> float:
    """Share of a residual's power (m,) that one column of ``slopes`` (m, k) removes.

    Alone, or after the other columns were projected out of both; the smaller of the two.
    """
    column, others = slopes[:, which], np.delete(slopes, which, axis=1)
    beside, _ = np.linalg.qr(others)
    left = [values - beside @ (beside.T @ values) for values in (column, residual)]
    return min(_alike(column, residual), _alike(*left))


def _alike(one: np.ndarray, other: np.ndarray) -> float:
    both = float(one @ one) * float(other @ other)
    return float(one @ other) ** 2 / both if both > 0.0 else 0.0
