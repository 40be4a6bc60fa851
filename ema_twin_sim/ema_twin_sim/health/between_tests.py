"""Random effects: what one more run of a healthy unit, in a test of its own, may look like.

A run is mean + what its test has in common + what is its own. Runs of one test are no independent witnesses of what
another test will bring, so the degrees of freedom are those of both variances together: with a variance all between
tests, the number of tests less one, however many runs there are. They are those of Nel and van der Merwe
(Communications in Statistics 15, 1986), which do not depend on the numbers' units (Krishnamoorthy and Yu, Statistics
& Probability Letters 66, 2004); of a single number they are Satterthwaite's. The limit is Hotelling's T² for one
further observation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats


@dataclass(frozen=True, eq=False)
class Prediction:
    """Where a further run of a further test lies, of p numbers."""

    mean: np.ndarray  # (p,) mean of the tests' means
    between: np.ndarray  # (p, p) covariance of the tests' means
    within: np.ndarray  # (p, p) what a single run varies by beyond that
    tests: int
    runs: int

    @property
    def covariance(self) -> np.ndarray:
        """Of a further run about the mean (p, p), with the mean's own error."""
        return self.between * (1.0 + 1.0 / self.tests) + self.within

    @property
    def spread(self) -> np.ndarray:
        """Standard deviations (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def degrees_of_freedom(self) -> float:
        """Of the covariance, by Nel and van der Merwe."""
        inverse = np.linalg.inv(self.between + self.within)
        count = len(self.mean)
        used = 0.0
        for part, freedom in ((self.between, self.tests - 1), (self.within, self.runs - self.tests)):
            if freedom > 0:
                share = part @ inverse
                used += (float(np.trace(share @ share)) + float(np.trace(share)) ** 2) / freedom
        return (count + count**2) / used

    def part(self, which: Sequence[int]) -> Prediction:
        """Of some of the numbers."""
        rows = list(which)
        square = np.ix_(rows, rows)
        return replace(self, mean=self.mean[rows], between=self.between[square], within=self.within[square])

    def distance(self, values: np.ndarray) -> float:
        """Squared distance (Mahalanobis) of p values."""
        off = values - self.mean
        return float(off @ np.linalg.solve(self.covariance, off))

    def tail(self, values: np.ndarray, freedom: float | None = None) -> float:
        """Natural logarithm of the probability that a healthy run is as far off; 0 where too few tests tell.

        With the degrees of freedom that are given, else the covariance's own.
        """
        count = len(self.mean)
        freedom = self.degrees_of_freedom if freedom is None else freedom
        left = freedom - count + 1.0
        if left <= 0.0:
            return 0.0
        return float(stats.f.logsf(self.distance(values) * left / (count * freedom), count, left))


def predict(values: np.ndarray, tests: Sequence[str]) -> Prediction:
    """From values (n, p) of healthy runs, and the test of each; two tests at least."""
    labels = np.asarray(tests)
    groups = [values[labels == test] for test in dict.fromkeys(tests)]
    means = np.array([group.mean(axis=0) for group in groups])
    runs, number = len(values), len(groups)
    between = np.atleast_2d(np.cov(means.T))  # holds a part of what varies within: one over the runs of a test
    within = np.zeros_like(between)
    if runs > number:
        off = np.concatenate([group - group.mean(axis=0) for group in groups])
        own = 1.0 - float(np.mean([1.0 / len(group) for group in groups]))
        within = own * (off.T @ off) / (runs - number)
    return Prediction(means.mean(axis=0), between, within, number, runs)
