"""The weighting that a fit is made under: where outliers begin, and by how much the noise is more than the sensors'."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from .wander import Wander

FAR = 1e9  # noise standard deviations that no row is away: least squares
INFLATED = 0.2  # share by which a variance moves before all is fitted again


@dataclass(frozen=True, eq=False)
class Weighting:
    """Misfits compare under one weighting only.

    ``cauchy_scale`` (m,) is the residual, in units of noise, from which on a row counts less and less.
    ``variance_inflation`` is what a squared residual is divided by to count as much as a prior's does: rows are
    correlated, and what no model explains acts as noise does. Without it the priors of the constants would compete with
    the sensors' noise alone, and friction that wanders would drag them anywhere. ``wander`` is what is known of that.
    """

    cauchy_scale: np.ndarray
    variance_inflation: float = 1.0
    wander: Wander | None = None

    @classmethod
    def even(cls, rows: int, scale: float) -> Weighting:
        """One scale for all rows, nothing inflated."""
        return cls(np.full(rows, scale))

    def begun_anew(self, scale: float) -> Weighting:
        """One scale for all rows and nothing inflated, beside what wanders."""
        return replace(Weighting.even(len(self.cauchy_scale), scale), wander=self.wander)

    def from_outliers(self, scale: float) -> Weighting:
        """The same with outliers that begin at one scale in all rows."""
        return replace(self, cauchy_scale=np.full(len(self.cauchy_scale), scale))

    def inflated(self, variance: float) -> Weighting:
        """The same with a noise of so many times the sensors' variance; itself where that is no other by much."""
        moved = abs(math.log(variance / self.variance_inflation)) > INFLATED
        return replace(self, variance_inflation=variance) if moved else self

    def is_that_of(self, other: Weighting) -> bool:
        """Whether both let all rows, and the priors, count alike."""
        return self is other or (
            self.wander is other.wander
            and self.variance_inflation == other.variance_inflation
            and np.array_equal(self.cauchy_scale, other.cauchy_scale)
        )
