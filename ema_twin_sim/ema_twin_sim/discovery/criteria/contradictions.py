"""Recordings that contradict each other: one alone would need far more friction, or inertia, than the others."""

from __future__ import annotations

import math

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
    backlash, in slow motion, inertia hardly shows and absorbs whatever impacts leave. Nor is a smaller inertia, if a
    disturbance may have caused so much of the acceleration, or its sensor's noise.
    """
    places = {free.path: k for k, free in enumerate(f.hypothesis.free)}
    columns = {name: places[path] for name, path in CONSTANTS.items() if path in places}
    if len(problem.observations) < 2 or not columns:
        return ()
    scale = f.variance_inflation
    # The scale parameters multiply the file's values, which are only guesses for open constants.
    guessed = np.array([free.prior is None for free in f.hypothesis.free])
    of_a_share = f.jacobian * np.where(guessed, f.hypothesis.values, 1.0)
    moves, errors, explain, at_most = [], [], [], []
    for part in problem.torque_parts:
        slopes = of_a_share[part][:, [*columns.values()]]
        covariance = np.linalg.inv(slopes.T @ slopes / scale + np.eye(len(columns)) / 0.5**2)
        moves.append(covariance @ (slopes.T @ f.residual[part]) / scale)
        errors.append(np.sqrt(np.diag(covariance)))
        explain.append([_explains(slopes, k, f.residual[part]) for k in range(len(columns))])
        at_most.append(moves[-1].copy())
        if "inertia" in columns:
            which = [*columns].index("inertia")
            at_most[-1][which] = max(moves[-1][which], _largest(slopes, which, f.residual[part]))
    usual = np.median(moves, axis=0)
    found = []
    for o, *numbers in zip(problem.observations, moves - usual, at_most - usual, errors, explain, strict=True):
        for name, share, most, error, gain in zip(columns, *numbers, strict=True):
            apart = max(SMALL, APART * error)
            if gain > PART and (share > apart or most < -apart):
                more = "more" if share > 0.0 else "less"
                found.append(
                    f"{o.name}: needs {abs(share):.0%} {more} {name} than the other recordings do; it may be of "
                    "another machine, or of one in another state (then judge it alone), or show what no effect explains"
                )
    return tuple(found)


def _largest(slopes: np.ndarray, which: int, residual: np.ndarray) -> float:
    """The largest share by which a recording's rows (m,) may change an inertia.

    An acceleration has noise, and a disturbance moves what a command drives. Regression of the torque on it then finds
    the inertia too small, and regression of it on the torque too large (Frisch's bounds).
    """
    column, rest = _beside_others(slopes, which, residual)
    torque = column + rest
    alike = float(torque @ column)
    return float(torque @ torque) / alike - 1.0 if alike > 0.0 else math.inf


def _explains(slopes: np.ndarray, which: int, residual: np.ndarray) -> float:
    """Share of a residual's power (m,) that one column of ``slopes`` (m, k) removes.

    Alone, or after the other columns were projected out of both; the smaller of the two.
    """
    return min(_alike(slopes[:, which], residual), _alike(*_beside_others(slopes, which, residual)))


def _beside_others(slopes: np.ndarray, which: int, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One column of ``slopes`` (m, k), and a residual (m,), after the other columns were projected out of both."""
    column = slopes[:, which]
    beside, _ = np.linalg.qr(np.delete(slopes, which, axis=1))
    return column - beside @ (beside.T @ column), residual - beside @ (beside.T @ residual)


def _alike(one: np.ndarray, other: np.ndarray) -> float:
    both = float(one @ one) * float(other @ other)
    return float(one @ other) ** 2 / both if both > 0.0 else 0.0
