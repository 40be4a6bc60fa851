"""Chance: what a generic basis gains on noise whose neighbouring rows resemble each other."""

from __future__ import annotations

import numpy as np

from .equation import EquationErrorProblem
from .fit import Fit
from .screening import span_of

DRAWS = 8  # of the noise; their mean is known to about a tenth for a basis with ten columns


def gain_on_alike_noise(problem: EquationErrorProblem, before: Fit, after: Fit, name: str) -> float:
    """Mean gain of a generic basis beside a fit ``before``, on noise with the spectrum of the residual ``after`` it.

    In units of the noise that is left. On white noise it is one for each column. Friction that wanders makes
    neighbouring rows alike, and columns as smooth as it then gain many times that. Each draw has the residual's
    amplitude spectrum, recording by recording, with random phases (Theiler et al., Testing for nonlinearity in time
    series: the method of surrogate data, Physica D 58, 1992).
    """
    basis, divisor = span_of(before, problem.generic_bases[name])
    rows = np.zeros((len(basis), DRAWS))
    draws = np.random.default_rng(0)
    for part in problem.torque_parts:
        left = after.residual[part]
        if len(left) > 1:
            amplitudes = np.abs(np.fft.rfft(left))[:, None]
            phases = np.exp(2j * np.pi * draws.random((len(amplitudes), DRAWS)))
            rows[part] = np.fft.irfft(amplitudes * phases, len(left), axis=0)
    rows[: len(divisor)] /= divisor[:, None]
    return float(np.mean(np.sum((basis.T @ rows) ** 2, axis=0)))
