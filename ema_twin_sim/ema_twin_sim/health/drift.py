"""Drift of a feature or a parameter: level, then a line from an onset on that nobody knows.

For each possible onset (every time that was recorded, but the last two) level and slope are a weighted least squares
fit. Onsets are weighted by their likelihood, with the width of what else fits integrated out (Laplace), so that what is
told of the slope or of a later value holds the doubt about the onset.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from ema_bench_replay.errors import InputError

from ..criteria import CONTRADICTED
from .change_point import inflation

_FEWEST = 5  # values


@dataclass(frozen=True, eq=False)
class Drift:
    """What the values do over time; with its parts by onset (k,)."""

    times: np.ndarray  # (n,)
    onsets: np.ndarray  # (k,), in the times' unit
    weights: np.ndarray  # (k,), of sum 1
    fits: np.ndarray  # (k, 2): level and slope of each
    covariances: np.ndarray  # (k, 2, 2)
    freedom: float  # degrees of freedom of the errors' size; infinite where they were given and hold

    @property
    def slope(self) -> float:
        """Per time, after the onset."""
        return float(self.weights @ self.fits[:, 1])

    @property
    def slope_error(self) -> float:
        """Standard error, with the doubt about the onset."""
        spread = self.weights @ (self.covariances[:, 1, 1] + (self.fits[:, 1] - self.slope) ** 2)
        return float(np.sqrt(spread))

    @property
    def is_trend(self) -> bool:
        """Whether the slope is beyond chance: each onset's in its own error, as likely as it is."""
        distance = np.abs(self.fits[:, 1]) / np.sqrt(self.covariances[:, 1, 1])
        return bool(float(self.weights @ distance) > CONTRADICTED)

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Value and standard error (k,) at a time, by each onset."""
        since = np.maximum(0.0, time - self.onsets)
        rows = np.column_stack([np.ones_like(since), since])
        values = np.einsum("ij,ij->i", rows, self.fits)
        errors = np.sqrt(np.einsum("ij,ijk,ik->i", rows, self.covariances, rows))
        return values, errors

    def now(self) -> tuple[float, float]:
        """Value and standard error at the last time."""
        values, errors = self.at(float(self.times[-1]))
        mean = float(self.weights @ values)
        return mean, float(np.sqrt(self.weights @ (errors**2 + (values - mean) ** 2)))


def drift(times: np.ndarray, values: np.ndarray, errors: np.ndarray) -> Drift:
    """From values (n,) with standard errors (n,) at rising times (n,). Raises InputError where they are too few."""
    times, values, errors = (np.asarray(x, dtype=np.float64) for x in (times, values, errors))
    if len(times) < _FEWEST or not (np.diff(times) > 0.0).all():
        raise InputError(f"{len(times)} values at rising times show no drift; give {_FEWEST}")
    onsets = times[:-2]
    fits, covariances, misfits = [], [], []
    for onset in onsets:
        rows = np.column_stack([np.ones(len(times)), np.maximum(0.0, times - onset)]) / errors[:, None]
        covariance = np.linalg.inv(rows.T @ rows)
        fit = covariance @ (rows.T @ (values / errors))
        fits.append(fit)
        covariances.append(covariance)
        misfits.append(float(np.sum((values / errors - rows @ fit) ** 2)))
    least = min(misfits)
    widened, freedom = inflation(least, len(times) - 3)
    spread = np.array(covariances) * widened**2
    logs = -0.5 * (np.array(misfits) - least) / widened**2
    weights = np.exp(logs)
    return Drift(times, onsets, weights / weights.sum(), np.array(fits), spread, freedom)


def slope_tail(found: Drift) -> float:
    """Probability that the slope is on the other side of zero than it seems."""
    distance = found.fits[:, 1] / np.sqrt(found.covariances[:, 1, 1])
    tail = stats.t.cdf(distance, found.freedom) if np.isfinite(found.freedom) else stats.norm.cdf(distance)
    up = float(found.weights @ tail)
    return min(up, 1.0 - up)
