"""How much of a signal's squared error is where the machine stands still, in which friction holds any torque up to some
level, and how much is in motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.long_columns import pieces

from ..criteria import CLEARLY_MORE, MOSTLY
from .where import Stretch


@dataclass(frozen=True)
class AtRest:
    """Which share of the samples and of the sum of squared errors is at standstill, over all recordings."""

    of_samples: float
    of_squares: float

    @property
    def rest_over_all(self) -> float:
        """The RMSE at standstill over that of all samples."""
        return math.sqrt(self.of_squares / self.of_samples)

    @property
    def motion_over_all(self) -> float:
        """The RMSE in motion over that of all samples."""
        return math.sqrt((1.0 - self.of_squares) / (1.0 - self.of_samples))


def at_rest(stretches: Sequence[Stretch], slow: float) -> AtRest | None:
    """The shares of all stretches at speeds up to ``slow`` [rad/s]; None unless that decides their RMSE.

    It does if most of the squared error is there, and clearly more than the samples that are there explain.
    """
    samples, squares = np.zeros(2), np.zeros(2)  # in motion, at standstill
    for stretch in stretches:
        for rows in pieces(len(stretch.residual)):
            residual, speed = stretch.residual[rows], stretch.speed[rows]
            known = np.isfinite(residual) & np.isfinite(speed)
            still = (np.abs(speed[known]) <= slow).astype(int)
            samples += np.bincount(still, minlength=2)
            with np.errstate(over="ignore"):  # of a twin that diverged
                squares += np.bincount(still, residual[known] ** 2, 2)
    if not samples.all() or not 0.0 < squares.sum() < math.inf:
        return None
    found = AtRest(samples[1] / samples.sum(), squares[1] / squares.sum())
    decides = found.of_squares > MOSTLY and found.rest_over_all > CLEARLY_MORE * found.motion_over_all
    return found if decides else None
