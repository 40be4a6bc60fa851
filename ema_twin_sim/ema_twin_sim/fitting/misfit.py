"""What a fit makes small: the error of both methods under one name, and how its rows count."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ..model import Model
from .freedom import Freedom

PIECES = 6
"""Fewest blocks of a jackknife; recordings are parted where there are fewer."""


class Misfit(Protocol):
    """The error of a model beside recordings: rows (m,) in units of noise.

    ``parts`` are the recording and the rows of each stretch, evenly spread over the recording's time; ``variance`` is
    that of one row, autocorrelation included: what priors are weighed against.
    """

    freedom: Freedom
    parts: list[tuple[int, slice]]
    rows: int
    variance: float

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Measured minus predicted (m,) at these values (k,). Raises InputError where the model loses its way."""
        ...

    def slopes(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weighted slopes of the prediction (m, k) per unit of each number."""
        ...

    def zero_shift(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weighted change of the prediction (m,) where every motor counter's zero is off by its noise."""
        ...

    def systematic(self, values: np.ndarray) -> np.ndarray:
        """By how much the method itself may be wrong in each number (k,)."""
        ...

    def weights(self, residual: np.ndarray) -> np.ndarray:
        """Square roots (m,) of what each row counts: outliers less and less."""
        ...

    def cost(self, residual: np.ndarray) -> float:
        """The sum that a fit makes small."""
        ...

    def reweigh(self, residual: np.ndarray) -> bool:
        """Let each part count by how well it can be met at all; whether that changed much."""
        ...


def blocks(misfit: Misfit) -> np.ndarray:
    """The block (m,) that each row belongs to: its recording, or a stretch of it where recordings are few."""
    recordings = 1 + max(recording for recording, _ in misfit.parts)
    pieces = -(-PIECES // recordings)
    found = np.zeros(misfit.rows, int)
    for recording, part in misfit.parts:
        count = part.stop - part.start
        found[part] = recording * pieces + (np.arange(count) * pieces) // max(count, 1)
    return found


def counter_noise(model: Model) -> dict[str, float]:
    """Noise and quantisation of one sample of the ``motor`` and ``output`` counters [rad of their own shafts]."""
    return {
        side: math.sqrt(model.value(f"sensors.{side}_encoder_noise") ** 2 + 1.0 / 12.0)
        * (2.0 * math.pi / model.value(f"sensors.{side}_encoder_counts"))
        for side in ("motor", "output")
    }
