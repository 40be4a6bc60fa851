"""How many independent values a residual is worth: its mean square scatters as that of so many.

What is left over is seldom white: a loop answers its sensors' noise, and what a model lacks lasts. Whatever makes
neighbours alike shows in the means of stretches, which then scatter more than those of independent values.
"""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.long_columns import pieces


def independent_rows(residual: np.ndarray) -> float:
    """Between 1 and the number of values (n,): by the scatter of root(n) means of stretches of their squares."""
    count = len(residual)
    length = math.isqrt(count)
    if length < 2:
        return float(min(count, 1))
    whole = length * (count // length)
    means = [_squares(residual, rows).reshape(-1, length).mean(axis=1) for rows in pieces(whole, length)]
    of_means = float(np.var(np.concatenate(means), ddof=1))
    mean = sum(np.sum(_squares(residual, rows)) for rows in pieces(whole)) / whole
    if of_means <= (length * np.finfo(float).eps * mean) ** 2:  # a constant's means differ by what rounding leaves
        return float(count)
    variance = sum(np.sum((_squares(residual, rows) - mean) ** 2) for rows in pieces(whole)) / whole
    return max(1.0, count * min(1.0, float(variance) / (length * of_means)))


def _squares(residual: np.ndarray, rows: slice) -> np.ndarray:
    return residual[rows] ** 2
