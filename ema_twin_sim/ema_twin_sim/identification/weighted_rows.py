"""Recordings under one weighting: residuals of a prediction, and the weight of each row."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from ..criteria import SMALL
from ..measured.observation import Observation
from .encoder_offsets import remove_means, remove_offsets
from .recorded_rows import RecordedRows
from .weighting import FAR, Weighting

S = TypeVar("S", bound="WeightedRows")


@dataclass(frozen=True, eq=False, init=False)
class WeightedRows(RecordedRows):
    """Recordings, their weighting, and whether the encoder rows count in addition to the torque rows.

    It is never changed: ``under`` and similar methods return another object that shares the rows.
    """

    weighting: Weighting
    use_encoder: bool
    measured: np.ndarray  # (m,) in units of the total noise, wandering included

    def __init__(self, observations: Sequence[Observation]) -> None:
        super().__init__(observations)
        vars(self).update(weighting=Weighting.even(self.rows, FAR), use_encoder=True, measured=self.in_noise)

    def under(self: S, weighting: Weighting) -> S:
        """The same rows under another weighting."""
        if weighting.wander is self.weighting.wander:
            return self._but(weighting=weighting)
        wander = weighting.wander
        measured = self.in_noise if wander is None else wander.whitened(self.in_noise)
        return self._but(weighting=weighting, measured=measured)

    def by_torque_alone(self: S) -> S:
        """The same without the encoder rows."""
        return self._but(use_encoder=False)

    def with_encoders(self: S) -> S:
        """The same with the encoder rows."""
        return self._but(use_encoder=True)

    def _but(self: S, **changed: object) -> S:
        other = copy(self)
        vars(other).update(changed)
        return other

    def compares_with(self, other: WeightedRows) -> bool:
        """Whether misfits to both compare: same rows, same weights."""
        return (
            self.observations is other.observations
            and self.use_encoder == other.use_encoder
            and self.weighting.is_that_of(other.weighting)
        )

    @property
    def judged(self) -> int:
        """Number of rows that are judged."""
        return self.rows if self.use_encoder else self.size

    def whitened(self, rows: np.ndarray) -> np.ndarray:
        """Convert rows (m,) or columns of rows (m, k) from units of the sensors' noise to units of the total noise.

        The direction of stops is projected out.
        """
        rows = self.stops.taken_out(rows)
        return rows if self.weighting.wander is None else self.weighting.wander.whitened(rows)

    def unexplained(self, predicted: np.ndarray) -> np.ndarray:
        """Measured minus predicted (m,), in units of noise, with the encoder offsets removed robustly."""
        rows = self.measured - predicted
        if not self.use_encoder:
            rows[self.size :] = 0.0
            return rows
        remove_offsets(rows, self.encoder_pieces, self.size, self.encoder_noise, self.weighting.cauchy_scale)
        return rows

    def weights(self, residual: np.ndarray) -> np.ndarray:
        """Square roots (m,) of the row weights, which decrease for outliers."""
        weights = 1.0 / np.sqrt(1.0 + (residual / self.weighting.cauchy_scale) ** 2)
        if not self.use_encoder:
            weights[self.size :] = 0.0
        return weights

    def misfit(self, residual: np.ndarray) -> float:
        """Cauchy misfit: squared for small residuals, logarithmic for outliers."""
        return float(self.costs(residual).sum())

    def costs(self, residual: np.ndarray) -> np.ndarray:
        """Contribution of each row (m,) to the misfit."""
        with np.errstate(over="ignore"):  # overflow means infinite cost
            return self.weighting.cauchy_scale**2 * np.log1p((residual / self.weighting.cauchy_scale) ** 2)

    def centred(self, rows: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Rows minus the weighted mean of each piece of encoder rows."""
        rows = rows.copy()
        remove_means(rows, self.encoder_pieces, self.size, self.encoder_noise, weights)
        return rows

    def reweighed(self, residual: np.ndarray, most: float = math.inf) -> Weighting:
        """The weighting whose outliers begin where the bulk of a residual (m,) ends, at most at ``most``.

        The current weighting is returned if it would hardly change.
        """
        scale = np.full(self.rows, FAR)
        for _, part in self.parts:
            if part.stop > part.start:
                scale[part] = min(most, self.outlier * max(1.0, 1.4826 * float(np.median(np.abs(residual[part])))))
        moved = bool((np.abs(np.log(scale / self.weighting.cauchy_scale)) > SMALL).any())
        return replace(self.weighting, cauchy_scale=scale) if moved else self.weighting
