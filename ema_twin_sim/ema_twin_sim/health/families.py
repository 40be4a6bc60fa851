"""Health: which family of damage changes the features in the way that a run's features have changed.

Each family is a set of directions: the features that it raises (+) or lowers (-), by any amount. The family is named
whose directions explain most of the change (least squares with non-negative amounts), less 2 for each direction by
Akaike's criterion. None of the directions was learnt from damaged units; each comes from physics:

==================  =================================================================================================
family              what it does
==================  =================================================================================================
friction up         dry or dirty contacts, tight seals: more effort both ways, and stick-slip
preload up          balls, nuts or bearings that fit tighter: more effort, and a machine that shakes and hunts less
friction down       lost preload, warm oil: less effort both ways
play                contacts that separate: the controller hunts across the gap, motion is rough at all rates, the
                    effort after a stroke falls as the load is released; two encoders differ; preload is lost too
local damage        pits and broken teeth: a wave or bumps at fixed places; material that is worn off reduces preload
load                effort that does not reverse with the motion
==================  =================================================================================================
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np
from scipy.optimize import nnls

from ..criteria import SUREST


class Family(Enum):
    """What may be wrong with a unit."""

    FRICTION_UP = "friction up"
    PRELOAD_UP = "preload up"
    FRICTION_DOWN = "friction down"
    PLAY = "play"
    LOCAL_DAMAGE = "local damage"
    LOAD = "load"
    UNKNOWN = "unknown"


DIRECTIONS: Mapping[Family, Mapping[str, tuple[int, ...]]] = {
    Family.FRICTION_UP: {"friction": (1,), "slow_roughness": (1,)},
    Family.PRELOAD_UP: {"friction": (1,), "fast_roughness": (-1,), "rest_hunting": (-1,)},
    Family.FRICTION_DOWN: {"friction": (-1,)},
    Family.PLAY: {
        **{"fast_roughness": (1,), "slow_roughness": (1,), "rest_hunting": (1,)},
        **{"settling": (-1,), "friction": (-1,), "lost_motion": (1,)},
    },
    Family.LOCAL_DAMAGE: {
        **{"wave_depth": (1,), "wave_both_ways": (1,), "bump": (1,)},
        **{"fast_roughness": (1,), "friction": (-1,)},
    },
    Family.LOAD: {"load": (1, -1)},
}
_AKAIKE = 2.0


@dataclass(frozen=True)
class Ranked:
    """A family, and how well it explains the change."""

    family: Family
    explained: float  # part of the squared change that it explains, less 2 for each direction
    probability: float  # among these families; none of them need be right
    because: tuple[str, ...]  # features that speak for it, the strongest first


def rank(changes: Mapping[str, float]) -> tuple[Ranked, ...]:
    """Rank the families by what they explain, from each feature's change in standard deviations of healthy runs."""
    naming = dict.fromkeys(name for directions in DIRECTIONS.values() for name in directions)
    names = [name for name in naming if np.isfinite(changes.get(name, np.nan))]
    values = np.array([changes[name] for name in names])
    found = []
    for family, directions in DIRECTIONS.items():
        axes = [(name, sign) for name, signs in directions.items() if name in names for sign in signs]
        if not axes:
            continue
        columns = np.array([[float(sign) if name == other else 0.0 for name, sign in axes] for other in names])
        amounts, left = nnls(columns, values)
        explained = float(values @ values - left**2) - _AKAIKE * len(axes)
        order = sorted(range(len(axes)), key=lambda i: -amounts[i])
        found.append((family, explained, tuple(axes[i][0] for i in order if amounts[i] > 1.0)))
    if not found:
        return ()
    best = max(explained for _, explained, _ in found)
    weights = [np.exp(0.5 * (explained - best)) for _, explained, _ in found]
    ranked = [
        Ranked(family, explained, min(SUREST, float(weight / sum(weights))), because)
        for (family, explained, because), weight in zip(found, weights, strict=True)
    ]
    return tuple(sorted(ranked, key=lambda one: -one.explained))
