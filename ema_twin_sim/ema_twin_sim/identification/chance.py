"""Chance: what a generic basis gains on noise of rows that resemble their neighbours."""

from __future__ import annotations

import numpy as np

from .equation import EquationErrorProblem
from .fit import Fit
from .screening import span_of


def gain_on_correlated_noise(problem: EquationErrorProblem, before: Fit, after: Fit, name: str) -> float:
    """Mean gain of a generic basis beside a fit ``before``, on noise with the spectrum of the residual ``after`` it.

    In units of the noise that is left. On white noise it is one for each column; where neighbouring rows are alike,
    columns as smooth as these gain many times that. The mean is over noise of random phases (Theiler et al., Testing
    for nonlinearity in time series: the method of surrogate data, Physica D 58, 1992), recording by recording.

    If the basis is part of the fit ``after``, that has taken its own share out of the spectrum: then this is a lower
    bound.
    """
    basis, divisor = span_of(before, problem.generic_bases[name])
    gained = 0.0
    for part in problem.torque_parts:
        left = after.residual[part]
        if len(left) == 0:
            continue
        power, along = (
            np.abs(np.fft.rfft(rows, axis=0)) ** 2 for rows in (left[:, None], basis[part] / divisor[part, None])
        )
        both_signs = np.full(len(power), 2.0)  # of a frequency; zero, and half the sample rate, have one
        both_signs[0] = 1.0
        if len(left) % 2 == 0:
            both_signs[-1] = 1.0
        gained += float(both_signs @ (power * along).sum(axis=1)) / len(left) ** 2
    return gained
