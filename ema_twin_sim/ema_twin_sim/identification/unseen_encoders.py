"""Encoder difference in recordings that the parameters were not fitted to."""

from __future__ import annotations

import math

import numpy as np

from .equation import EquationErrorProblem
from .fit import Fit
from .uncertainty import held_out


def parting_where_unseen(f: Fit) -> float:
    """RMS [rad, slow shaft] of the unexplained encoder difference, each recording with parameters from the others."""
    return parting(f.problem, held_out(f.problem, f)[1])


def parting(problem: EquationErrorProblem, residual: np.ndarray) -> float:
    """RMS [rad, slow shaft] of the encoder difference in a residual (m,)."""
    left = residual[problem.size :] * problem.encoder_noise
    return math.sqrt(float(left @ left) / len(left))


def parting_explained_where_unseen(bare: Fit, f: Fit) -> np.ndarray:
    """By recording with encoder rows: what ``f`` explains of the encoder difference beyond ``bare``.

    Each recording is predicted with parameters from the others. In units of the noise that ``f`` leaves.
    """
    problem = f.problem
    before, after = (problem.costs(held_out(problem, one)[1]) for one in (bare, f))
    gained = (before - after) / f.variance_inflations[1]
    return np.array([gained[part].sum() for part in problem.encoder_parts if part.stop > part.start])
