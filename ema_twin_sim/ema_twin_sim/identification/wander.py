"""Wander: friction of a real machine that is a few per cent more or less from minute to minute.

No effect of a catalogue explains it. To a fit it is noise: large, slow, and in the directions that friction changes
in. Taken as such, it neither drags the constants nor is dressed up as a load that happens to look alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Wander:
    """By what share friction wanders, and the torque rows (m,) seen through the noise that this makes.

    With a covariance of 1 + s² C Cᵀ, where C is what friction would add over time, rows are multiplied by its inverse
    root: the more friction wanders, the less weight the rows along C get.
    """

    share: float
    parts: tuple[tuple[slice, np.ndarray, np.ndarray], ...]  # rows of a recording, directions (m, k), spreads (k,)
    gain: float  # twice the log-likelihood over a friction that does not wander

    @property
    def complexity_penalty(self) -> float:
        """The logarithm of the covariance's determinant: what it costs to let so much happen."""
        return float(sum(np.sum(np.log1p((self.share * spreads) ** 2)) for _, _, spreads in self.parts))

    def whitened(self, rows: np.ndarray) -> np.ndarray:
        """Rows (m,) or columns of rows (m, c), the wandering part of them made as small as the rest of the noise."""
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
