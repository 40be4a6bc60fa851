"""Random effects: what one more run of a healthy unit, in a test of its own, may look like.

A run is mean + what its test has in common + what is its own. Runs of one test are no independent witnesses of what
another test will bring, so the degrees of freedom are those of both variances by Satterthwaite's approximation
(Biometrics Bulletin 2, 1946): with a variance all between tests, the number of tests less one, however many runs there
are. The limit is that of Hotelling's T² for one further observation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats


@dataclass(frozen=True, eq=False)
class Prediction:
    """Where a further run of a further test lies, of p numbers."""

    mean: np.ndarray  # (p,) mean of the tests' means
    covariance: np.ndarray  # (p, p) of a further run about that mean, with the mean's own error
    degrees_of_freedom: float

    @property
    def spread(self) -> np.ndarray:
        """Standard deviations (p,)."""
        return np.sqrt(np.diag(self.covariance))

    def part(self, which: Sequence[int]) -> Prediction:
        """Of some of the numbers."""
        rows = list(which)
        return Prediction(self.mean[rows], self.covariance[np.ix_(rows, rows)], self.degrees_of_freedom)

    def distance(self, values: np.ndarray) -> float:
        """Squared distance (Mahalanobis) of p values."""
        off = values - self.mean
        return float(off @ np.linalg.solve(self.covariance, off))

    def tail(self, values: np.ndarray) -> float:
        """Natural logarithm of the probability that a healthy run is as far off; 0 where too few tests tell."""
        count = len(self.mean)
        left = self.degrees_of_freedom - count + 1.0
        if left <= 0.0:
            return 0.0
        ratio = self.distance(values) * left / (count * self.degrees_of_freedom)
        return float(stats.f.logsf(ratio, count, left))


def predict(values: np.ndarray, tests: Sequence[str]) -> Prediction:
    """From values (n, p) of healthy runs, and the test of each; two tests at least."""
    labels = np.asarray(tests)
    groups = [values[labels == test] for test in dict.fromkeys(tests)]
    means = np.array([group.mean(axis=0) for group in groups])
    runs, number = len(values), len(groups)
    between = np.atleast_2d(np.cov(means.T))  # of tests' means: holds within / (runs of a test) too
    own = 1.0 - float(np.mean([1.0 / len(group) for group in groups]))
    within = np.zeros_like(between)
    if runs > number:
        off = np.concatenate([group - group.mean(axis=0) for group in groups])
        within = off.T @ off / (runs - number)
    spread = between + own * within
    scale = np.maximum(np.diag(spread), 1e-30)
    shares = np.diag(between) / scale, own * np.diag(within) / scale
    inverse = shares[0] ** 2 / (number - 1) + (shares[1] ** 2 / (runs - number) if runs > number else 0.0)
    return Prediction(means.mean(axis=0), spread + between / number, float(1.0 / np.mean(inverse)))
