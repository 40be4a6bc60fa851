"""Recordings that contradict each other: one alone would have far more friction, or inertia, than the others."""

from __future__ import annotations

import numpy as np

from ...criteria import APART, SMALL
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit

GROUPS = {"inertia": ("scale.inertia",), "friction": ("scale.viscous_friction", "scale.coulomb_friction")}


def contradictions(problem: EquationErrorProblem, f: Fit) -> tuple[str, ...]:
    """One sentence for each recording whose machine is not that of the others.

    Each recording is asked, to first order, by which share of what was fitted it alone would move inertia and friction;
    the median of all is what it is held against. Single frictions are not asked for: one recording seldom tells them
    apart.
    """
    places = {free.path: k for k, free in enumerate(f.hypothesis.free)}
    groups = {name: [places[path] for path in paths if path in places] for name, paths in GROUPS.items()}
    groups = {name: columns for name, columns in groups.items() if columns}
    if len(problem.observations) < 2 or not groups:
        return ()
    scale = f.variance_inflation
    of_fitted = f.jacobian * f.hypothesis.values  # slopes per share: scales are free per unit of the file's
    moves, errors = [], []
    for part in problem.torque_parts:
        slopes = np.stack([of_fitted[part][:, columns].sum(axis=1) for columns in groups.values()], axis=1)
        covariance = np.linalg.inv(slopes.T @ slopes / scale + np.eye(len(groups)) / 0.5**2)
        moves.append(covariance @ (slopes.T @ f.residual[part]) / scale)
        errors.append(np.sqrt(np.diag(covariance)))
    away = np.array(moves) - np.median(moves, axis=0)
    found = []
    for o, shares, sure in zip(problem.observations, away, errors, strict=True):
        for name, share, error in zip(groups, shares, sure, strict=True):
            if abs(share) > max(SMALL, APART * error):
                more = "more" if share > 0.0 else "less"
                found.append(
                    f"{o.name}: needs {abs(share):.0%} {more} {name} than the other recordings do; it may be of "
                    "another machine, or of one in another state (then judge it alone), or show what no effect explains"
                )
    return tuple(found)
