"""Effective number of independent values in a residual, by the scatter of its mean square.

A residual is seldom white: a control loop responds to its sensors' noise, and missing effects persist. Any correlation
between neighbours shows in the means of stretches, which then scatter more than those of independent values.
"""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.long_columns import pieces


def independent_rows(residual: np.ndarray) -> float:
    """Number between 1 and n (for n values), from the scatter of the mean squares of root(n) stretches."""
    count = len(residual)
    length = math.isqrt(count)
    if length < 2:
        return float(min(count, 1))
    whole = length * (count // length)
    means = [_squares(residual, rows).reshape(-1, length).mean(axis=1) for rows in pieces(whole, length)]
    of_means = float(np.var(np.concatenate(means), ddof=1))
    mean = sum(np.sum(_squares(residual, rows)) for rows in pieces(whole)) / whole
    if of_means <= (length * np.finfo(float).eps * mean) ** 2:  # the means of a constant differ only by rounding
        return float(count)
    variance = sum(np.sum((_squares(residual, rows) - mean) ** 2) for rows in pieces(whole)) / whole
    return max(1.0, count * min(1.0, float(variance) / (length * of_means)))


def _squares(residual: np.ndarray, rows: slice) -> np.ndarray:
    return residual[rows] ** 2
