"""What a fit makes small: the error of both methods under one name, and how its rows count."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from .free_parameters import FreeParameters


class Misfit(Protocol):
    """The error of a model beside recordings: rows (m,) in units of noise.

    ``parts`` are the recording and the rows of each stretch, evenly spread over the recording's time; ``variance`` is
    that of one row, autocorrelation included: what priors are weighed against.
    """

    freedom: FreeParameters
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
