"""The error that a fit minimises: one interface for both methods, with the weights of its rows."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from .free_parameters import FreeParameters


class Misfit(Protocol):
    """The error of a model on recordings: rows (m,) in units of noise.

    ``parts`` are pairs of a recording and the rows of a stretch, evenly spread over the recording's time. ``variance``
    is that of one row including autocorrelation; it is the scale for weighing rows against priors.
    """

    freedom: FreeParameters
    parts: list[tuple[int, slice]]
    rows: int
    variance: float

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Measured minus predicted (m,) at these values (k,). Raises InputError if the model cannot be simulated."""
        ...

    def slopes(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weighted slopes of the prediction (m, k) with respect to each parameter."""
        ...

    def zero_shift(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weighted change of the prediction (m,) if every motor counter's zero is off by its noise."""
        ...

    def systematic(self, values: np.ndarray) -> np.ndarray:
        """Systematic error of the method in each parameter (k,)."""
        ...

    def weights(self, residual: np.ndarray) -> np.ndarray:
        """Square roots (m,) of the row weights, which decrease for outliers."""
        ...

    def cost(self, residual: np.ndarray) -> float:
        """The cost that a fit minimises."""
        ...

    def reweigh(self, residual: np.ndarray) -> bool:
        """Weight each part by how well it can be matched at all; return whether that changed much."""
        ...
