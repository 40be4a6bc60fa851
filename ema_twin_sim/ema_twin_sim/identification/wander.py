"""Wander: friction of a real machine that varies by a few per cent from minute to minute.

No effect of the catalogue explains it. For a fit it is noise: large, slow, and along the directions in which friction
can change. Treated as noise, it neither shifts the constants nor appears as a load that happens to look alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Wander:
    """The share by which friction wanders, and the whitening of torque rows (m,) that follows from it.

    With covariance 1 + s² C Cᵀ, where the columns of C are what friction would add over time, rows are multiplied by
    the inverse square root: the more friction wanders, the less weight the rows along C get.
    """

    share: float
    parts: tuple[tuple[slice, np.ndarray, np.ndarray], ...]  # rows of a recording, directions (m, k), spreads (k,)
    gain: float  # twice the log-likelihood gain over friction that does not wander

    @property
    def complexity_penalty(self) -> float:
        """Logarithm of the covariance's determinant: the cost of allowing this much variation."""
        return float(sum(np.sum(np.log1p((self.share * spreads) ** 2)) for _, _, spreads in self.parts))

    def equals(self, other: Wander) -> bool:
        """Whether rows are whitened alike by both, however much either gains."""
        return self.share == other.share and all(
            mine[0] == theirs[0] and np.array_equal(mine[1], theirs[1]) and np.array_equal(mine[2], theirs[2])
            for mine, theirs in zip(self.parts, other.parts, strict=True)
        )

    def whitened(self, rows: np.ndarray) -> np.ndarray:
        """Rows (m,) or columns of rows (m, c), with the wandering part scaled down to the remaining noise."""
        return self._scaled(rows, -0.5)

    def as_measured(self, rows: np.ndarray) -> np.ndarray:
        """The inverse of ``whitened``."""
        return self._scaled(rows, 0.5)

    def _scaled(self, rows: np.ndarray, power: float) -> np.ndarray:
        out = rows.copy()
        for part, directions, spreads in self.parts:
            factors = (1.0 + (self.share * spreads) ** 2) ** power - 1.0
            out[part] += (directions * factors) @ (directions.T @ rows[part])
        return out
