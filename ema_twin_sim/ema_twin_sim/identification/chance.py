"""Chance: what a generic basis gains on noise of rows that resemble their neighbours."""

from __future__ import annotations

import numpy as np

from .equation import EquationErrorProblem
from .fit import Fit
from .screening import span_of

FREQUENCIES = 8.0
"""Frequencies whose mean is the power at one: a third of it in error, which a basis of many columns averages out."""


def gain_on_correlated_noise(problem: EquationErrorProblem, before: Fit, after: Fit, name: str) -> float:
    """Mean decrease in misfit by a generic basis beside a fit ``before``, on noise like the residual ``after`` it.

    On white noise of one unit it is one for each column; where neighbouring rows are alike, columns as smooth as these
    gain many times that. The mean is over noise of random phases with the residual's spectrum (Theiler et al., Testing
    for nonlinearity in time series: the method of surrogate data, Physica D 58, 1992), recording by recording. What the
    basis itself took out of that spectrum is filled in from neighbouring frequencies. Operating points have no
    neighbours: their noise is white.
    """
    basis, _ = span_of(before, problem.generic_bases[name])
    gained = 0.0
    for o, part in zip(problem.observations, problem.torque_parts, strict=True):
        left, columns = after.residual[part], basis[part]
        if len(left) == 0:
            continue
        if o.of_points:
            share = float(np.sum(columns**2)) / len(left)
            gained += float(left @ left) / max(1.0 - share, 1.0 / len(left)) * share
            continue
        of_left, of_columns = (np.abs(np.fft.rfft(rows, axis=0)) ** 2 for rows in (left[:, None], columns))
        share = of_columns.sum(axis=1) / len(left)  # of a frequency's power that the basis takes
        gained += float(_both_signs(len(left)) @ (_filled(of_left[:, 0], share) * share)) / len(left)
    return gained


def _both_signs(count: int) -> np.ndarray:
    """How often each frequency of a real transform counts: zero, and half the sample rate, have one sign."""
    signs = np.full(count // 2 + 1, 2.0)
    signs[0] = 1.0
    if count % 2 == 0:
        signs[-1] = 1.0
    return signs


def _filled(power: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Power (f,) by frequency before a ``share`` (f,) of it was taken, from as many neighbours as it needs."""
    kept = np.maximum(1.0 - share, 0.0)
    sums, shares = (np.concatenate([[0.0], np.cumsum(values)]) for values in (power, kept))
    places = np.arange(len(power))
    needed = min(FREQUENCIES, 0.5 * shares[-1])
    filled = np.zeros(len(power))
    open_yet = np.ones(len(power), bool)
    width = 0
    while open_yet.any():
        first, stop = np.maximum(places - width, 0), np.minimum(places + width + 1, len(power))
        mass = shares[stop] - shares[first]
        enough = open_yet & ((mass >= needed) | ((first == 0) & (stop == len(power))))
        filled[enough] = (sums[stop] - sums[first])[enough] / np.maximum(mass[enough], 1e-12)
        open_yet &= ~enough
        width = max(1, 2 * width)
    return filled
