"""Columns of bases: arbitrary dependences of a torque, linear in their coefficients."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..measured.observation import Observation
from ..measured.smoothing import smooth_many_at
from .equation import EquationErrorProblem


def hat_columns(x: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """(n, k) piecewise linear hat functions: each is one at its own of the ``knots`` (k,) and zero at the others."""
    return np.stack([np.interp(x, knots, np.eye(len(knots))[k]) for k in range(len(knots))], 1)


def at_rows_of(o: Observation, columns: np.ndarray) -> np.ndarray:
    """Torques at full rate (n, k) [N m], converted to the torque rows (m, k) of one recording in units of noise."""
    out = np.empty((len(o.rows), columns.shape[1]))
    smooth_many_at(np.ascontiguousarray(columns), o.kernel, o.rows, out)
    out /= o.torque_noise[:, None]
    return out


def at_rows(problem: EquationErrorProblem, columns: Sequence[np.ndarray]) -> np.ndarray:
    """Torques at full rate, one array (n, k) per recording [N m], at all rows (m, k) in units of the total noise."""
    out = np.zeros((problem.rows, columns[0].shape[1]))
    for o, part, c in zip(problem.observations, problem.torque_parts, columns, strict=True):
        out[part] = at_rows_of(o, c)
    return problem.whitened(out)
