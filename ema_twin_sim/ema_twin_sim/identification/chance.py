"""Chance: what a generic basis gains on noise of rows like their neighbours, and how surely it tells two fits apart.

Such noise is drawn with the spectrum of what a fit leaves and random phases (Theiler et al., Testing for nonlinearity
in time series: the method of surrogate data, Physica D 58, 1992).
"""

from __future__ import annotations

import numpy as np

from .equation import EquationErrorProblem
from .fit import Fit
from .screening import span_of

DRAWS = 32  # of the noise
BINS = 5  # frequencies


def gain_on_alike_noise(problem: EquationErrorProblem, before: Fit, after: Fit, name: str) -> float:
    """Mean gain of a generic basis beside a fit ``before``, on noise with the spectrum of the residual ``after`` it.

    In units of the noise that is left. On white noise it is one for each column. Friction that wanders makes
    neighbouring rows alike, and columns as smooth as it then gain many times that.
    """
    basis, divisor = span_of(before, problem.generic_bases[name])
    rows = np.zeros((len(basis), DRAWS))
    rows[: problem.size] = _alike_noise(problem, after) / divisor[: problem.size, None]
    return float(np.mean(np.sum((basis.T @ rows) ** 2, axis=0)))


def told_apart(better: Fit, other: Fit) -> float:
    """Standard deviations by which the torque rows tell two fits apart, on noise like the residual of the ``better``.

    On white noise this is the distance of their predictions in units of the noise. Smooth predictions beside friction
    that wanders are told apart less surely than that.
    """
    problem = better.problem
    one, two = (f.residual[: problem.size] for f in (better, other))
    away = two - one
    lost = float(two @ two - one @ one)
    spread = 2.0 * float(np.std(away @ _alike_noise(problem, better)))
    return (lost + float(away @ away)) / max(spread, 1e-300)


def _alike_noise(problem: EquationErrorProblem, f: Fit) -> np.ndarray:
    """Draws (s, ``DRAWS``) of noise with the spectrum of the torque that a fit leaves, recording by recording.

    The spectrum is smoothed over ``BINS`` frequencies (Daniell), as each of them alone is known to a factor of two.
    """
    rows = np.zeros((problem.size, DRAWS))
    draws = np.random.default_rng(0)
    for part in problem.torque_parts:
        left = f.residual[part]
        if len(left) > 1:
            power = np.pad(np.abs(np.fft.rfft(left)) ** 2, BINS // 2, "reflect" if len(left) > 2 * BINS else "edge")
            amplitudes = np.sqrt(np.convolve(power, np.full(BINS, 1.0 / BINS), "valid"))[:, None]
            phases = np.exp(2j * np.pi * draws.random((len(amplitudes), DRAWS)))
            rows[part] = np.fft.irfft(amplitudes * phases, len(left), axis=0)
    return rows
