"""Health: which family of damage changes the features in the way that a run's features have changed.

Each family is a set of directions: the features that it raises (+) or lowers (-), by any amount. The family is named
whose directions explain most of the change (least squares with non-negative amounts), less 2 for each direction by
Akaike's criterion. None of the directions was learnt from damaged units; each comes from physics:

==================  =================================================================================================
family              what it does
==================  =================================================================================================
friction up         dry or dirty contacts, tight seals: more effort both ways and while settling, stick-slip in motion
                    and at rest
preload up          balls, nuts or bearings that fit tighter: more effort, and a machine that shakes and hunts less
friction down       lost preload, warm oil: less effort both ways and while settling
play                contacts that separate: the controller hunts across the gap, motion is rough at all rates, the
                    effort after a stroke falls as the load is released; two encoders differ; preload is lost too
local damage        pits and broken teeth: a wave or bumps at fixed places, rough at the rate at which these are passed;
                    material that is worn off reduces preload, so that friction falls and the controller hunts
load                effort that does not reverse with the motion; it is held after a stroke, too
==================  =================================================================================================

Each family also has features that measure directly what it is: the lost motion between two encoders is the play. If
one of them was recorded and none moved in its direction, the family is out of the question.

The unknown competes with the families: a change that is free in all features, in both directions of each. It explains
everything, at the cost of all these directions. The directions of a family hold only roughly, so what a family leaves
counts against it beyond a quarter of the squared change (1 - ``MOSTLY``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..criteria import CONTRADICTED, LIKELY, MOSTLY, SUREST


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
    Family.FRICTION_UP: {"friction": (1,), "slow_roughness": (1,), "settling": (1,), "rest_hunting": (1,)},
    Family.PRELOAD_UP: {"friction": (1,), "settling": (1,), "fast_roughness": (-1,), "rest_hunting": (-1,)},
    Family.FRICTION_DOWN: {"friction": (-1,), "settling": (-1,)},
    Family.PLAY: {
        **{"fast_roughness": (1,), "slow_roughness": (1,), "rest_hunting": (1,)},
        **{"settling": (-1,), "friction": (-1,), "lost_motion": (1,)},
    },
    Family.LOCAL_DAMAGE: {
        **{"wave_depth": (1,), "wave_both_ways": (1,), "bump": (1,)},
        **{"fast_roughness": (1,), "slow_roughness": (1,), "friction": (-1,), "rest_hunting": (1,)},
    },
    Family.LOAD: {"load": (1, -1)},
}
DIRECT: Mapping[Family, tuple[str, ...]] = {
    Family.FRICTION_UP: ("friction",),
    Family.PRELOAD_UP: ("friction",),
    Family.FRICTION_DOWN: ("friction",),
    Family.PLAY: ("lost_motion",),
    Family.LOCAL_DAMAGE: ("wave_depth", "wave_both_ways", "bump"),
    Family.LOAD: ("load",),
}
"""The features that measure directly what a family is."""
_FOLLOWING: Mapping[Family, tuple[str, tuple[int, ...], str]] = {
    Family.PLAY: ("settling", (1,), "rest_hunting"),
    Family.LOCAL_DAMAGE: ("settling", (1,), "rest_hunting"),
    Family.LOAD: ("settling", (1, -1), "load"),
}
"""A feature that another one takes along, at most as far: effort that hunts or is held is an effort after a stroke."""
_SHARES = ("wave_depth", "wave_both_ways", "bump")
"""Shares of the effort or of its scatter. They fall as what they are shares of rises, which is told by other features.
"""
_AKAIKE = 2.0


@dataclass(frozen=True)
class Ranked:
    """A family, and how well it explains the change."""

    family: Family
    explained: float  # part of the squared change that it explains, less 2 for each direction
    probability: float  # among these families and the unknown
    because: tuple[str, ...]  # features that speak for it, the strongest first; of the unknown, those left unexplained


@dataclass(frozen=True)
class _Explanation:
    """What a family explains of a change, and what it leaves."""

    family: Family
    explained: float
    directions: int
    left: Mapping[str, float]  # change that it does not explain, by feature
    because: tuple[str, ...] = ()


def rank(changes: Mapping[str, float], beside: Mapping[str, float] | None = None) -> tuple[Ranked, ...]:
    """Rank the families and the unknown by what they explain, from each feature's change in standard deviations.

    ``beside`` holds changes of features that hardly vary in healthy runs: their size has no scale to be judged by, but
    they tell whether a direct measure moved. Empty if no feature belongs to a family.
    """
    naming = dict.fromkeys(name for directions in DIRECTIONS.values() for name in directions)
    known = {name: changes[name] for name in naming if np.isfinite(changes.get(name, np.nan))}
    values = {name: max(0.0, change) if name in _SHARES else change for name, change in known.items()}
    if not values:
        return ()
    found = [
        _explanation(family, values)
        for family, directions in DIRECTIONS.items()
        if any(name in values for name in directions) and _moved(family, {**(beside or {}), **values})
    ]
    found.append(_unknown(values, max(found, key=lambda one: one.explained, default=None)))
    best = max(one.explained for one in found)
    weights = [float(np.exp(0.5 * (one.explained - best))) for one in found]
    ranked = [
        Ranked(one.family, one.explained, min(SUREST, weight / sum(weights)), one.because)
        for one, weight in zip(found, weights, strict=True)
    ]
    return tuple(sorted(ranked, key=lambda one: -one.explained))


def _moved(family: Family, values: Mapping[str, float]) -> bool:
    """Whether the direct measures of a family moved in its direction; if none was recorded, whether any feature did."""
    signs = DIRECTIONS[family]
    part = {name: max(0.0, *(sign * values[name] for sign in signs[name])) for name in signs if name in values}
    if recorded := {name: part[name] for name in DIRECT[family] if name in part}:
        return _squared(recorded) > CONTRADICTED**2
    return max(part.values(), default=0.0) > LIKELY


def _explanation(family: Family, values: Mapping[str, float]) -> _Explanation:
    """What the directions of a family explain."""
    signs = {name: signs for name, signs in DIRECTIONS[family].items() if name in values}
    part = {name: max(0.0, *(sign * values[name] for sign in its)) for name, its in signs.items()}
    follower, ways, leader = _FOLLOWING.get(family, ("", (), ""))
    if follower in values and leader in part:
        follows = min(part[leader], max(way * values[follower] for way in ways))
        part[follower] = max(follows, part.get(follower, 0.0))
    directions = sum(map(len, signs.values()))
    left = {name: abs(change) - part.get(name, 0.0) for name, change in values.items()}
    return _Explanation(
        family,
        _squared(values) - _squared(left) - _AKAIKE * directions,
        directions,
        left,
        tuple(name for name in sorted(part, key=lambda name: -part[name]) if part[name] > 1.0),
    )


def _unknown(values: Mapping[str, float], best: _Explanation | None) -> _Explanation:
    """The unknown: it explains what the best family leaves, and pays for both directions of every feature."""
    left = {name: abs(change) for name, change in values.items()} if best is None else best.left
    cost = _AKAIKE * (2 * len(values) - (0 if best is None else best.directions))
    gained = _squared(left)
    if best is not None:
        gained /= 1.0 + (1.0 - MOSTLY) * _squared(values) / max(cost, _AKAIKE)
    return _Explanation(
        Family.UNKNOWN,
        (0.0 if best is None else best.explained) + gained - cost,
        2 * len(values),
        {},
        tuple(name for name in sorted(left, key=lambda name: -left[name]) if left[name] > LIKELY),
    )


def _squared(changes: Mapping[str, float]) -> float:
    """The squared size of a change."""
    return sum(change**2 for change in changes.values())
