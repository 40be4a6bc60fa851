"""Encoder difference in recordings that the parameters were not fitted to."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .equation import EquationErrorProblem
from .fit import Fit
from .uncertainty import held_out


def parting_where_unseen(f: Fit) -> float:
    """RMS [rad, slow shaft] of the unexplained encoder difference, each recording with parameters from the others."""
    numbers = held_out(f.problem, f) if len(f.problem.observations) > 1 else [f.hypothesis.values]
    return parting(f.problem, f, numbers)


def parting(problem: EquationErrorProblem, f: Fit, numbers: Sequence[np.ndarray]) -> float:
    """RMS [rad, slow shaft] of the unexplained encoder difference, each recording with its own entry of ``numbers``."""
    square = 0.0
    for part, values in zip(problem.encoder_parts, numbers, strict=True):
        left = problem.residual(problem.predict(f.hypothesis.at(values)))[part] * problem.noise_of_encoders(part)
        square += float(left @ left)
    return math.sqrt(square / (problem.rows - problem.size))
