"""Health: which family of damage moves the features as a run's were moved.

Each family is a set of directions: what it raises (+) or lowers (-), and by how much it may is free. The family whose
directions take most of the change away (least squares with amounts that are not negative), less 2 for each direction
as Akaike's criterion has it, is named. None of the directions was learnt from damaged units; each is physics:

==================  =================================================================================================
family              what it does
==================  =================================================================================================
friction up         dry or dirty contacts, tight seals: more effort both ways, and slip that sticks
preload up          balls, nuts or bearings that fit tighter: more effort, and a machine that shakes and hunts less
friction down       preload that is lost, oil that is warm: less effort both ways
play                contacts that part: the control hunts across the gap, motion is rough at all rates, the effort after
                    a stroke falls as the load is let go; two encoders part; preload goes with it
local damage        pits and broken teeth: a wave or bumps that stay at their places; what is worn off loosens preload
load                effort that does not turn round with the motion
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
    """A family and how it fares."""

    family: Family
    explained: float  # of the squared change, less what its directions cost
    probability: float  # among the families, none of which need be right
    because: tuple[str, ...]  # features that speak for it, the strongest first


def rank(changes: Mapping[str, float]) -> tuple[Ranked, ...]:
    """The families by what they explain, from each feature's change in standard deviations of healthy runs."""
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
