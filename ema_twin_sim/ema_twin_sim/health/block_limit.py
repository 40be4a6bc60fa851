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

_BEYOND = 60
"""Draws that are to be beyond the limit: the rate is then known to an eighth."""
_DRAWS = 16_000
"""At least, and at once: what a false alarm in 270 runs needs; it bounds the memory."""
_MOST = 200_000
"""At most, half a second: enough for a false alarm in 3,300 runs, the share of one of twelve motions."""


def block_limit(prediction: Prediction, rate: float) -> float:
    """Log tail probability that is below by a share ``rate`` of healthy runs, for the features of a prediction.

    Few draws do not reach the limit of a very low rate; it is then at most the rate itself.
    """
    rng = np.random.default_rng(0)  # the same limit each time
    draws = min(max(_DRAWS, math.ceil(_BEYOND / rate)), _MOST)
    parts = [_tails(rng, prediction, min(_DRAWS, draws - done)) for done in range(0, draws, _DRAWS)]
    limit = math.log(max(float(np.quantile(np.concatenate(parts), rate)), np.finfo(float).tiny))
    return limit if rate * _MOST >= _BEYOND else min(limit, math.log(rate))


def _tails(rng: np.random.Generator, prediction: Prediction, draws: int) -> np.ndarray:
    """Tail probabilities (n,) of a healthy run each, by a baseline of its own."""
    count, tests = len(prediction.mean), prediction.tests
    between = _covariances(rng, prediction.between, tests - 1, draws)
    within = _covariances(rng, prediction.within, prediction.runs - tests, draws)
    off = _normal(rng, prediction.between * (1.0 + 1.0 / tests) + prediction.within, draws)
    distance = np.einsum(
        "ni,ni->n", off, np.linalg.solve(between * (1.0 + 1.0 / tests) + within, off[..., None])[..., 0]
    )
    return hotelling_tail(distance, count, degrees_of_freedom(between, within, tests, prediction.runs))


def _normal(rng: np.random.Generator, covariance: np.ndarray, draws: int) -> np.ndarray:
    return rng.normal(size=(draws, len(covariance))) @ _root(covariance).T


def _covariances(rng: np.random.Generator, covariance: np.ndarray, freedom: int, draws: int) -> np.ndarray:
    """Estimates (n, p, p) of a covariance (p, p) with so many degrees of freedom."""
    count = len(covariance)
    if freedom <= 0:
        return np.zeros((draws, count, count))
    if freedom < count:
        factor = rng.normal(size=(draws, count, freedom))
    else:
        factor = np.tril(rng.normal(size=(draws, count, count)), -1)
        for row in range(count):
            factor[:, row, row] = np.sqrt(rng.chisquare(freedom - row, size=draws))
    factor = _root(covariance) @ factor
    return np.asarray(factor @ factor.transpose(0, 2, 1) / freedom)


def _root(covariance: np.ndarray) -> np.ndarray:
    """A factor of a covariance, which may lack rank."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
