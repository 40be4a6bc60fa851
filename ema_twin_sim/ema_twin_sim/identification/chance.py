"""Chance: what noise of rows that resemble their neighbours gives a generic basis, or any one direction."""

from __future__ import annotations

import math

import numpy as np

from .equation import EquationErrorProblem
from .fit import Fit
from .screening import span_of

NEIGHBOURS = 16
"""Frequencies whose median replaces the power at one that a basis explains: its standard error is then a third."""
EXPLAINED = 0.5
"""Share of a frequency from which on too little is left of it to tell its power."""


def gain_on_correlated_noise(problem: EquationErrorProblem, before: Fit, after: Fit, name: str) -> float:
    """Mean decrease in misfit by a generic basis beside a fit ``before``, on noise like the residual ``after`` it.

    On white noise of one unit it is one for each column; where neighbouring rows are alike, columns as smooth as these
    gain many times that. The mean is over noise of random phases with the residual's spectrum (Theiler et al., Testing
    for nonlinearity in time series: the method of surrogate data, Physica D 58, 1992), recording by recording. At
    frequencies that the basis explains, the power is that of their neighbours: a lower bound where it rises towards
    them, as towards the slowest frequencies of friction that wanders. Operating points have no neighbours: their noise
    is white.
    """
    basis, _ = span_of(before, problem.generic_bases[name])
    return _power_along(problem, after.residual, basis, basis)


def noise_along(problem: EquationErrorProblem, f: Fit, direction: np.ndarray) -> float:
    """Standard deviation of the sum of noise times a ``direction`` (m,), over the torque rows.

    The noise is like a fit's residual, of its spectrum recording by recording, with what the fit's own numbers took out
    filled in as above; at operating points it is white.
    """
    taken, _ = np.linalg.qr(f.jacobian[: problem.size])
    return math.sqrt(_power_along(problem, f.residual, taken, direction[:, None]))


def _power_along(problem: EquationErrorProblem, residual: np.ndarray, taken: np.ndarray, columns: np.ndarray) -> float:
    """Mean power of noise along columns (m, k), summed over these, in the torque rows.

    The noise is like a ``residual`` (m,) before an orthonormal basis ``taken`` (m, j) was taken out of it.
    """
    found = 0.0
    for o, part in zip(problem.observations, problem.torque_parts, strict=True):
        rows = part.stop - part.start
        if rows == 0:
            continue
        left, gone, along = residual[part], taken[part], columns[part]
        if o.of_points:
            share = float(np.sum(gone**2)) / rows
            found += float(left @ left) / max(rows * (1.0 - share), 1.0) * float(np.sum(along**2))
            continue
        power, taken_power, along_power = (
            (np.abs(np.fft.rfft(each, axis=0)) ** 2).sum(axis=1) for each in (left[:, None], gone, along)
        )
        found += float(_multiplicity(rows) @ (_before_it(power, taken_power / rows) * along_power)) / rows**2
    return found


def _multiplicity(rows: int) -> np.ndarray:
    """How often each frequency of a real transform counts: zero, and half the sample rate, have one sign."""
    signs = np.full(rows // 2 + 1, 2.0)
    signs[0] = 1.0
    if rows % 2 == 0:
        signs[-1] = 1.0
    return signs


def _before_it(power: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Power (f,) by frequency before a basis took its ``share`` (f,) of it."""
    told = np.flatnonzero(share < EXPLAINED)
    if len(told) == 0:
        return power
    before = power.copy()
    before[told] = power[told] / (1.0 - share[told])
    for place in np.flatnonzero(share >= EXPLAINED):
        first = np.searchsorted(told, place) - NEIGHBOURS
        near = told[max(first, 0) : first + 2 * NEIGHBOURS]
        near = near[np.argsort(np.abs(near - place), kind="stable")[:NEIGHBOURS]]
        # power is exponentially distributed; a line among the neighbours hardly moves the median
        before[place] = np.median(before[near]) / math.log(2.0)
    return before
