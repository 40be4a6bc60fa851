"""Chance: what a generic basis gains, and how surely two fits are told apart, beside friction that wanders.

To the likelihood of white noise any smooth curve then gains, and the smallest difference of two curves is certain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..criteria import CORRELATION
from .equation import EquationErrorProblem
from .fit import Fit, fit
from .screening import span_of
from .wandering import wandering


def gain_on_alike_noise(problem: EquationErrorProblem, before: Fit, after: Fit, name: str) -> float:
    """Mean gain of a generic basis beside a fit ``before``, on noise with the spectrum of the residual ``after`` it.

    In units of the noise that is left. On white noise it is one for each column; where neighbouring rows are alike,
    columns as smooth as these gain many times that. The mean is over noise of random phases (Theiler et al., Testing
    for nonlinearity in time series: the method of surrogate data, Physica D 58, 1992), recording by recording.
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


def told_apart(better: Fit, other: Fit) -> float:
    """Standard deviations by which the torque rows tell two fits apart, with what wanders as part of the noise.

    That is how far the ``better`` one's lead exceeds what noise gives it if the other is right.
    """
    problem = better.problem
    wander = None if problem.weighting.wander is not None else wandering(problem, better)
    if wander is not None:
        used = {*better.hypothesis.generic_bases, *other.hypothesis.generic_bases}
        beside = problem.under(replace(problem.weighting, wander=wander)).with_generic_bases(
            {name: wander.whitened(problem.generic_bases[name]) for name in used}
        )
        better, other = (fit(beside, f.hypothesis) for f in (better, other))
    one, two = (f.residual[: problem.size] for f in (better, other))
    away = two - one
    lost = float(two @ two - one @ one)
    noise = np.sqrt(CORRELATION * np.mean(one**2))
    return (lost + float(away @ away)) / max(2.0 * float(np.linalg.norm(away)) * noise, 1e-300)
