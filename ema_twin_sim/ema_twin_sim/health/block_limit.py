"""The limit of features that are judged together: drawn from how healthy baselines of that many tests and runs scatter.

The degrees of freedom of a covariance of two parts are an approximation (``between_tests``), which calls off too many
runs where tests differ much more than runs and are few. So baselines are drawn that a unit with the estimated
covariances may show: covariances by Wishart's distribution (Bartlett's decomposition, so the memory does not grow with
the number of runs), the mean, and one more run each. The limit is the tail probability that the stated share of these
runs is below.
"""

from __future__ import annotations

import math

import numpy as np

from .between_tests import Prediction, degrees_of_freedom, hotelling_tail

_DRAWS = 16_000
"""The rate is then known to an eighth for a false alarm in 270 runs."""


def block_limit(prediction: Prediction, rate: float) -> float:
    """Log tail probability that is below by a share ``rate`` of healthy runs, for the features of a prediction."""
    rng = np.random.default_rng(0)  # the same limit each time
    count, tests = len(prediction.mean), prediction.tests
    freedoms = tests - 1, prediction.runs - tests
    between = _covariances(rng, prediction.between, freedoms[0])
    within = _covariances(rng, prediction.within, freedoms[1])
    off = _normal(rng, prediction.between * (1.0 + 1.0 / tests) + prediction.within)
    distance = np.einsum(
        "ni,ni->n", off, np.linalg.solve(between * (1.0 + 1.0 / tests) + within, off[..., None])[..., 0]
    )
    tails = hotelling_tail(distance, count, degrees_of_freedom(between, within, tests, prediction.runs))
    return math.log(max(float(np.quantile(tails, rate)), np.finfo(float).tiny))


def _normal(rng: np.random.Generator, covariance: np.ndarray) -> np.ndarray:
    return rng.normal(size=(_DRAWS, len(covariance))) @ _root(covariance).T


def _covariances(rng: np.random.Generator, covariance: np.ndarray, freedom: int) -> np.ndarray:
    """Estimates (n, p, p) of a covariance (p, p) with so many degrees of freedom."""
    count = len(covariance)
    if freedom <= 0:
        return np.zeros((_DRAWS, count, count))
    if freedom < count:
        factor = rng.normal(size=(_DRAWS, count, freedom))
    else:
        factor = np.tril(rng.normal(size=(_DRAWS, count, count)), -1)
        for row in range(count):
            factor[:, row, row] = np.sqrt(rng.chisquare(freedom - row, size=_DRAWS))
    factor = _root(covariance) @ factor
    return np.asarray(factor @ factor.transpose(0, 2, 1) / freedom)


def _root(covariance: np.ndarray) -> np.ndarray:
    """A factor of a covariance, which may lack rank."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
