"""The error that a fit minimises: one interface for both methods, with the weights of its rows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

import numpy as np

from .free_parameters import FreeParameters

T = TypeVar("T")


class Last(Generic[T]):
    """A function of values (k,) that remembers its last result."""

    def __init__(self, of: Callable[[np.ndarray], T]) -> None:
        self._of = of
        self._known: tuple[np.ndarray, T] | None = None

    def __call__(self, values: np.ndarray) -> T:
        """The result at these values."""
        if self._known is None or not np.array_equal(self._known[0], values):
            self._known = (values.copy(), self._of(values))
        return self._known[1]


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
        """Weight each part by how well it can be matched at all; return whether that changed much.

        A copy made before keeps the weights that it had.
        """
        ...
