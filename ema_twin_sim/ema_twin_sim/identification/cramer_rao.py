"""Cramér-Rao bound: the smallest covariance of the free parameters that any unbiased estimator can reach.

The noise is the residual of a fit with its own spectrum (Blackman-Tukey estimate by recording), so that correlated
neighbouring rows are not counted twice. The fit should contain the true effects.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cholesky_banded
from scipy.linalg.lapack import dtbtrs

from .equation import EquationErrorProblem
from .fit import Fit, prior_rows
from .uncertainty import scaled_inverse

LAGS = 0.1
"""Share of a recording over which its noise may be correlated: resolves ten periods in it."""
MOST_LAGS = 1000
"""Upper limit in rows, so that memory grows linearly with the length of a recording."""
NOTHING = 1e-18
"""Variance, relative to the sensors' noise, added where nothing is left."""


def cramer_rao(problem: EquationErrorProblem, f: Fit) -> np.ndarray:
    """Covariance (k, k) of the free parameters at the bound, priors on constants included."""
    _, priors = prior_rows(f.hypothesis)
    return scaled_inverse(fisher_information(problem, f.residual, f.jacobian) + priors.T @ priors)


def fisher_information(problem: EquationErrorProblem, noise: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Information (k, k) of slopes (m, k) in a noise (m,), summed over recordings and kinds of row."""
    information = np.zeros((slopes.shape[1], slopes.shape[1]))
    for k, part in problem.parts:
        o = problem.observations[k]
        if part.stop - part.start < 2:
            continue
        white = whitened(o.rows if part.start < problem.size else o.encoder_rows, noise[part], slopes[part])
        information += white.T @ white
    return information


def whitened(at: np.ndarray, noise: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Slopes (m, k) whitened for a correlated ``noise`` (m,); rows are at samples ``at`` (m,), with some missing.

    Parzen's window keeps the estimated covariance positive semidefinite.
    """
    step = int(np.diff(at).min())
    place = (at - at[0]) // step
    grid, there = np.zeros(place[-1] + 1), np.zeros(place[-1] + 1)
    grid[place], there[place] = noise, 1.0
    lags = min(max(2, round(LAGS * len(grid))), MOST_LAGS)
    size = 2 * len(grid)
    power = np.abs(np.fft.rfft(grid, size)) ** 2
    correlation = np.fft.irfft(power, size)[: len(grid)] / there.sum()
    u = np.arange(len(grid)) / lags
    window = np.where(u <= 0.5, 1.0 - 6.0 * u**2 + 6.0 * u**3, 2.0 * np.clip(1.0 - u, 0.0, 1.0) ** 3)
    kept = np.append((correlation * window)[: lags + 1], np.zeros(max(0, len(grid) - lags - 1)))
    # The window makes the covariance banded: each row correlates with up to this many places before it.
    band = np.zeros((min(lags, len(place) - 1) + 1, len(place)))
    for k in range(len(band)):
        band[k, : len(place) - k] = kept[place[k:] - place[: len(place) - k]]
    band[0] += 1e-9 * band[0, 0] + NOTHING
    white, _ = dtbtrs(cholesky_banded(band, lower=True), slopes, uplo="L")
    return np.asarray(white)
