"""Separation: how surely the torque tells two fits apart, with friction that wanders as part of the noise.

To the likelihood of white noise, the smallest difference of two smooth curves is certain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..criteria import CORRELATION
from .fit import Fit, fit
from .wandering import wandering


def separation(better: Fit, other: Fit) -> float:
    """Standard deviations between two fits by their torque rows, with what wanders as part of the noise.

    That is how far the ``better`` one's lead exceeds what noise gives it if the other is right. The encoders and the
    constants' priors are left out.
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
