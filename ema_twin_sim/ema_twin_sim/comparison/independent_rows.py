"""How many independent values a residual is worth: its mean square scatters as that of so many.

What is left over is seldom white: a loop answers its sensors' noise, and what a model lacks lasts. Whatever makes
neighbours alike shows in the means of stretches, which then scatter more than those of independent values.
"""

from __future__ import annotations

import math

import numpy as np


def independent_rows(residual: np.ndarray) -> float:
    """Between 1 and the number of values (n,): by the scatter of root(n) means of stretches of their squares."""
    count = len(residual)
    length = math.isqrt(count)
    if length < 2:
        return float(min(count, 1))
    squares = residual[: length * (count // length)] ** 2
    of_means = float(np.var(squares.reshape(-1, length).mean(axis=1), ddof=1))
    if of_means == 0.0:
        return float(count)
    return max(1.0, count * min(1.0, float(np.var(squares)) / (length * of_means)))
