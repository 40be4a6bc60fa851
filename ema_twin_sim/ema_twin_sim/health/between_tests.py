"""Random effects: how far one more run of a healthy unit, in a new test, may be off.

A run is the mean + a part common to its test + a part of its own. Runs of one test are not independent evidence of what
another test will give, so the degrees of freedom are those of both variances together: if all variance is between
tests, the number of tests minus one, however many runs there are. They are those of Nel and van der Merwe
(Communications in Statistics 15, 1986), which do not depend on the units of the features (Krishnamoorthy and Yu,
Statistics & Probability Letters 66, 2004); for a single feature they are Satterthwaite's. The limit is Hotelling's T²
for one further observation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy import special


@dataclass(frozen=True, eq=False)
class Prediction:
    """Distribution of one more run of one more test, in p features."""

    mean: np.ndarray  # (p,) mean of the tests' means
    between: np.ndarray  # (p, p) covariance of the tests' means
    within: np.ndarray  # (p, p) covariance of single runs about the mean of their test
    tests: int
    runs: int
    _parts: dict[tuple[int, ...], Prediction] = field(default_factory=dict, repr=False)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Covariance (p, p) of one more run about the mean, with the mean's own error."""
        return self.between * (1.0 + 1.0 / self.tests) + self.within

    @property
    def spread(self) -> np.ndarray:
        """Standard deviations (p,)."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def degrees_of_freedom(self) -> float:
        """Degrees of freedom of the covariance, by Nel and van der Merwe."""
        return float(degrees_of_freedom(self.between, self.within, self.tests, self.runs))

    def with_scatter_added(self, added: np.ndarray) -> Prediction:
        """The same with tests that scatter more, by standard deviations ``added`` (p,) of each feature for itself."""
        return replace(self, between=self.between + np.diag(added**2), _parts={})

    def part(self, which: Sequence[int]) -> Prediction:
        """The prediction of some of the features; the same one each time, since it knows what it has computed."""
        rows = tuple(which)
        if rows not in self._parts:
            square = np.ix_(rows, rows)
            mean, between, within = self.mean[list(rows)], self.between[square], self.within[square]
            self._parts[rows] = Prediction(mean, between, within, self.tests, self.runs)
        return self._parts[rows]

    def distance(self, values: np.ndarray) -> float:
        """Squared distance (Mahalanobis) of p values."""
        off = values - self.mean
        return float(off @ self._inverse @ off)

    @cached_property
    def _inverse(self) -> np.ndarray:
        return np.linalg.inv(self.covariance)

    def tail(self, values: np.ndarray, freedom: float | None = None) -> float:
        """Natural logarithm of the probability that a healthy run is as far off; 0 if there are too few tests.

        Uses the degrees of freedom ``freedom`` if given, else the covariance's own.
        """
        freedom = self.degrees_of_freedom if freedom is None else freedom
        with np.errstate(divide="ignore"):  # farther off than numbers can tell
            return float(np.log(hotelling_tail(self.distance(values), len(self.mean), freedom)))


def degrees_of_freedom(between: np.ndarray, within: np.ndarray, tests: int, runs: int) -> np.ndarray:
    """Degrees of freedom (...) of covariances that are sums of two parts (..., p, p), by Nel and van der Merwe."""
    inverse = np.linalg.inv(between + within)
    count = inverse.shape[-1]
    used = np.zeros(inverse.shape[:-2])
    for part, freedom in ((between, tests - 1), (within, runs - tests)):
        if freedom > 0:
            share = part @ inverse
            trace = np.trace(share, axis1=-2, axis2=-1)
            used += (np.einsum("...ij,...ji->...", share, share) + trace**2) / freedom
    return np.asarray((count + count**2) / used)


def hotelling_tail(distance: np.ndarray | float, count: int, freedom: np.ndarray | float) -> np.ndarray:
    """Probability (...) that ``count`` features are farther off than a squared distance; 1 if the freedom is too low.

    ``freedom`` is that of the covariance which the distance was measured by.
    """
    left = np.asarray(freedom - count + 1.0)
    known = np.maximum(left, np.finfo(float).tiny)
    return np.where(left > 0.0, special.fdtrc(count, known, distance * left / (count * freedom)), 1.0)


def predict(values: np.ndarray, tests: Sequence[str]) -> Prediction:
    """Estimate the prediction from values (n, p) of healthy runs and the test of each; needs at least two tests."""
    labels = np.asarray(tests)
    groups = [values[labels == test] for test in dict.fromkeys(tests)]
    means = np.array([group.mean(axis=0) for group in groups])
    runs, number = len(values), len(groups)
    between = np.atleast_2d(np.cov(means.T))  # includes the variance within tests over the runs of a test
    within = np.zeros_like(between)
    if runs > number:
        off = np.concatenate([group - group.mean(axis=0) for group in groups])
        own = 1.0 - float(np.mean([1.0 / len(group) for group in groups]))
        within = own * (off.T @ off) / (runs - number)
    return Prediction(means.mean(axis=0), between, within, number, runs)
