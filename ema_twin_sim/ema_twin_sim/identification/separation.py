"""Separation: how surely the rows tell two fits apart, with wandering friction as part of the torque's noise.

To the likelihood of white noise, the smallest difference of two smooth curves is certain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..criteria import RIVAL_MARGIN
from .chance import noise_along
from .comparable import as_compares, refuse_different_weightings
from .fit import Fit, fit
from .wandering import wandering


def beside_its_wander(f: Fit) -> Fit:
    """The fit with the friction that wanders in its residual as part of the noise; itself if none does."""
    problem = f.problem
    wander = None if problem.weighting.wander is not None else wandering(problem, f)
    if wander is None:
        return f
    bases = {name: wander.whitened(problem.generic_bases[name]) for name in f.hypothesis.generic_bases}
    return fit(problem.under(replace(problem.weighting, wander=wander)).with_generic_bases(bases), f.hypothesis)


def separation(better: Fit, other: Fit) -> float:
    """Standard deviations between two fits by their torque rows, under the weighting of the ``better`` one.

    That is how far the ``better`` one's lead exceeds what noise like its residual gives it if the other is right. The
    constants' priors are left out, and so are the encoders, in which friction does not wander. Both hold the same
    generic bases.
    """
    problem = better.problem
    raw = as_compares(other, problem).raw
    one, two = (residual[: problem.size] * better.weights[: problem.size] for residual in (better.raw, raw))
    away = two - one
    lost = float(two @ two - one @ one)
    white = float(np.linalg.norm(away)) * np.sqrt(problem.correlation * np.mean(one**2))
    return (lost + float(away @ away)) / max(2.0 * white, 2.0 * noise_along(problem, better, away), 1e-300)


def encoders_tell_apart(one: Fit, other: Fit) -> bool:
    """Whether two fits differ by more than a close rival may in how they explain the encoder difference."""
    refuse_different_weightings(one, other)
    inflation = min(one.variance_inflations[1], other.variance_inflations[1])
    return bool(abs(one.misfits[1] - other.misfits[1]) > RIVAL_MARGIN * inflation)
