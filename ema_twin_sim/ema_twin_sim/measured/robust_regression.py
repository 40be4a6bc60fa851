"""Least squares in which values that are far off what the others follow count less."""

from __future__ import annotations

import numpy as np

from ..criteria import OUTLIER

_STEPS = 20


def robust_regression(columns: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Factors (k,) of ``columns`` (n, k) whose sum is nearest to ``values`` (n,), and the weights (n,) of these."""
    size = np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
    weights = np.ones(len(values))
    for _ in range(_STEPS):
        found = np.linalg.lstsq(columns / size * weights[:, None], values * weights, rcond=None)[0] / size
        left = values - columns @ found
        bulk = 1.4826 * float(np.median(np.abs(left)))
        if bulk == 0.0:
            break
        weights = 1.0 / np.sqrt(1.0 + (left / (OUTLIER * bulk)) ** 2)
    return found, weights
