"""Weighting of a fit: where outliers begin, and how much larger the noise is than the sensors'."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .wander import Wander

FAR = 1e9  # in noise standard deviations; no row is that far off: least squares
INFLATED = 0.2  # change of the log variance beyond which everything is fitted again


@dataclass(frozen=True, eq=False)
class Weighting:
    """Weights of rows and priors. Misfits compare only under the same weighting.

    ``cauchy_scale`` (m,) is the residual, in units of noise, from which on a row gets less and less weight.
    ``variance_inflation`` is the divisor that puts squared residuals on the same scale as priors: rows are correlated,
    and what no model explains acts as noise. Without it the priors of the constants would compete with the sensors'
    noise alone, and wandering friction would drag them anywhere. ``wander`` describes that friction.
    """

    cauchy_scale: np.ndarray
    variance_inflation: float = 1.0
    wander: Wander | None = None

    @classmethod
    def even(cls, rows: int, scale: float) -> Weighting:
        """One scale for all rows, variance inflation of one."""
        return cls(np.full(rows, scale))

    def begun_anew(self, scale: float) -> Weighting:
        """One scale for all rows and variance inflation of one; the wander is kept."""
        return replace(Weighting.even(len(self.cauchy_scale), scale), wander=self.wander)

    def from_outliers(self, scale: float) -> Weighting:
        """The same with one outlier scale in all rows."""
        return replace(self, cauchy_scale=np.full(len(self.cauchy_scale), scale))

    def inflated(self, variance: float) -> Weighting:
        """The same with the noise variance at this multiple of the sensors'; unchanged if it hardly differs."""
        moved = abs(math.log(variance / self.variance_inflation)) > INFLATED
        return replace(self, variance_inflation=variance) if moved else self

    def is_that_of(self, other: Weighting) -> bool:
        """Whether both give rows and priors the same weights."""
        return self is other or (
            self.wander is other.wander
            and self.variance_inflation == other.variance_inflation
            and np.array_equal(self.cauchy_scale, other.cauchy_scale)
        )
