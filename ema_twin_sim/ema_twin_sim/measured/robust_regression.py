"""Least squares in which values that are far off what the others follow count less, or nothing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..criteria import OUTLIER

_STEPS = 20


def robust_regression(columns: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Factors (k,) of ``columns`` (n, k) whose sum is nearest to ``values`` (n,), and the weights (n,) of these."""
    return _reweighted(columns, values, np.ones(len(values)), lambda far: 1.0 / np.sqrt(1.0 + far**2))


def bulk_regression(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Factors (k,) by the values that agree with each other: those that are far off count nothing."""
    return bulk_weights(columns, values)[0]


def bulk_weights(columns: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The factors (k,) of ``bulk_regression`` and the weights (n,) of the values.

    It begins where ``robust_regression`` ends, which many values pull if they are all off to one side
    (A. E. Beaton and J. W. Tukey, Technometrics 16 (1974) 147).
    """
    _, weights = robust_regression(columns, values)
    return _reweighted(columns, values, weights, lambda far: np.clip(1.0 - far**2, 0.0, None))


def _reweighted(
    columns: np.ndarray, values: np.ndarray, weights: np.ndarray, weighting: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Factors (k,) and weights (n,), by turns; ``weighting`` gives these by how far off values are, in outliers."""
    size = np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
    for _ in range(_STEPS):
        found = np.linalg.lstsq(columns / size * weights[:, None], values * weights, rcond=None)[0] / size
        left = values - columns @ found
        bulk = 1.4826 * float(np.median(np.abs(left)))
        if bulk == 0.0:
            break
        weights = weighting(left / (OUTLIER * bulk))
    return found, weights
