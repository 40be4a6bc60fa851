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
encoder             one of two encoders is eccentric or slips: their difference scatters within a stroke, or drifts
local damage        pits and broken teeth: a wave or bumps at fixed places, rough at the rate at which these are passed;
                    material that is worn off reduces preload, so that friction falls and the controller hunts
load                effort that does not reverse with the motion; it is held after a stroke, too
offset              the same of the current sensor: nothing but the effort changes
==================  =================================================================================================

Each family has features that measure directly what it is: the lost motion between two encoders is the play. If none of
them was recorded, or none moved in its direction, the family is out of the question. So is a family that does not
explain the feature that changed most, and one whose direct measures moved by less than a quarter of that. With one
encoder, play is measured by the preload that it takes away: by effort that falls, if nothing rises much more.

The train winds up with the effort. What the difference of both encoders grows by no more than the effort, as a share,
is no play, and what it scatters and drifts by no more than the lost motion is no encoder's fault.

The unknown competes with the families: a change that is free in all features, in both directions of each. It explains
everything, at the cost of all these directions. The directions of a family hold only roughly, so what a family leaves
counts against it beyond a quarter of the squared change (1 - ``MOSTLY``).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..criteria import CONTRADICTED, LIKELY, MOSTLY, PART, SUREST
from .encoders import NEARLY_REPEATABLE


class Family(Enum):
    """What may be wrong with a unit."""

    FRICTION_UP = "friction up"
    PRELOAD_UP = "preload up"
    FRICTION_DOWN = "friction down"
    PLAY = "play"
    ENCODER = "output encoder"
    LOCAL_DAMAGE = "local damage"
    LOAD = "load"
    OFFSET = "offset of the effort"
    UNKNOWN = "unknown"


DIRECTIONS: Mapping[Family, Mapping[str, tuple[int, ...]]] = {
    Family.FRICTION_UP: {"friction": (1,), "slow_roughness": (1,), "settling": (1,), "rest_hunting": (1,)},
    Family.PRELOAD_UP: {"friction": (1,), "settling": (1,), "fast_roughness": (-1,), "rest_hunting": (-1,)},
    Family.FRICTION_DOWN: {"friction": (-1,), "settling": (-1,)},
    Family.PLAY: {
        **{"fast_roughness": (1,), "slow_roughness": (1,), "rest_hunting": (1,)},
        **{"settling": (-1,), "friction": (-1,), "lost_motion": (1,), "encoder_reach": (1,)},
    },
    Family.ENCODER: dict.fromkeys(("encoder_scatter", "encoder_drift", "encoder_reach", "lost_motion"), (1,)),
    Family.LOCAL_DAMAGE: {
        **{"wave_depth": (1,), "wave_both_ways": (1,), "bump": (1,)},
        **{"fast_roughness": (1,), "slow_roughness": (1,), "friction": (-1,), "rest_hunting": (1,)},
    },
    Family.LOAD: {"load": (1, -1)},
    Family.OFFSET: {"load": (1, -1)},
}
DIRECT: Mapping[Family, tuple[str, ...]] = {
    Family.FRICTION_UP: ("friction",),
    Family.PRELOAD_UP: ("friction",),
    Family.FRICTION_DOWN: ("friction",),
    Family.PLAY: ("lost_motion", "encoder_reach"),
    Family.ENCODER: ("encoder_scatter", "encoder_drift"),
    Family.LOCAL_DAMAGE: ("wave_depth", "wave_both_ways", "bump"),
    Family.LOAD: ("load",),
    Family.OFFSET: ("load",),
}
"""The features that measure directly what a family is."""
_FOLLOWING: Mapping[Family, tuple[tuple[str, tuple[int, ...], str], ...]] = {
    Family.PLAY: (("settling", (1,), "rest_hunting"),),
    Family.LOCAL_DAMAGE: (("settling", (1,), "rest_hunting"),),
    Family.LOAD: (("settling", (1, -1), "load"), ("slow_roughness", (1,), "load")),
    Family.OFFSET: (("settling", (1, -1), "load"),),
}
"""Features that another one takes along, at most as far: effort that hunts or is held is an effort after a stroke. A
load on an arm varies along a stroke."""
_BESIDE: Mapping[Family, Mapping[str, tuple[int, ...]]] = {
    Family.FRICTION_UP: {"lag": (1,), "breakaway": (1, -1), "roughness": (1,)},
    Family.PRELOAD_UP: {"lag": (1,), "breakaway": (1, -1), "roughness": (-1,)},
    Family.FRICTION_DOWN: {"lag": (-1,), "breakaway": (1, -1)},
    Family.PLAY: {"lag": (1, -1), "breakaway": (1, -1), "roughness": (1,)},
    Family.LOCAL_DAMAGE: {"roughness": (1,)},
    Family.LOAD: {"lag": (1, -1), "breakaway": (1, -1), "roughness": (1,)},
}
"""What a family may change besides. It speaks for no family, but may be what changed most. The effort to break away is
told as what exceeds the effort in motion, which grows with friction, too."""
_SHARES = ("wave_depth", "wave_both_ways", "bump")
"""Shares of the effort or of its scatter. They fall as what they are shares of rises, which is told by other features.
"""
_WITH_A_LOAD = ("breakaway", "lag", "roughness", "slow_roughness")
"""What a load changes besides the effort that it takes: its inertia and how it varies along a stroke."""
_EFFORTS = ("friction", "load", "settling", "breakaway")
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


def rank(
    changes: Mapping[str, float],
    beside: Mapping[str, float] | None = None,
    growths: Mapping[str, float] | None = None,
    without: Collection[Family] = (),
) -> tuple[Ranked, ...]:
    """Rank the families and the unknown by what they explain, from each feature's change in standard deviations.

    ``beside`` holds changes of features that hardly vary in healthy runs: their size has no scale to be judged by, but
    they tell whether a direct measure moved. ``growths`` holds by which share features grew, where that is known.
    Families of ``without`` are out of the question. Empty if no feature belongs to a family.
    """
    every = dict.fromkeys(name for of in (DIRECTIONS, _BESIDE) for directions in of.values() for name in directions)
    known = {name: changes[name] for name in every if np.isfinite(changes.get(name, np.nan))}
    more = _more_than_wound_up(growths or {}, known)
    alone = {name: _by_itself(name, change, more, growths or {}) for name, change in known.items()}
    values = {name: change for name, change in alone.items() if any(name in of for of in DIRECTIONS.values())}
    if not values:
        return ()
    # What nearly repeats is off by standard deviations at once, so it has to grow by a considerable share, too.
    slight = {name for name in NEARLY_REPEATABLE if more.get(name, np.inf) <= PART}
    measured = {**(beside or {}), **{name: change for name, change in alone.items() if name not in slight}}
    found = [
        _explanation(family, values)
        for family in DIRECTIONS
        if family not in without and _moved(family, measured, alone) and _explains_most(family, alone)
    ]
    found.append(_unknown(values, alone, max(found, key=lambda one: one.explained, default=None)))
    best = max(one.explained for one in found)
    weights = [float(np.exp(0.5 * (one.explained - best))) for one in found]
    ranked = [
        Ranked(one.family, one.explained, min(SUREST, weight / sum(weights)), one.because)
        for one, weight in zip(found, weights, strict=True)
    ]
    return tuple(sorted(ranked, key=lambda one: -one.explained))


def _more_than_wound_up(growths: Mapping[str, float], known: Mapping[str, float]) -> dict[str, float]:
    """By which share the measures of the encoders' difference grew, beyond what winds the train up.

    Lost motion that moved from about zero grew by any share: an output that floats in a gap scatters and drifts in it.
    """
    wound = max(0.0, *(growths.get(name, 0.0) for name in _EFFORTS))
    opened = np.inf if known.get("lost_motion", 0.0) > CONTRADICTED else 0.0
    loose = max(wound, growths.get("lost_motion", opened))
    beyond = {"lost_motion": wound, "encoder_reach": wound, "encoder_scatter": loose, "encoder_drift": loose}
    return {name: growths[name] - own for name, own in beyond.items() if name in growths}


def _by_itself(name: str, change: float, more: Mapping[str, float], growths: Mapping[str, float]) -> float:
    """The part of a change that no other feature tells."""
    if name in _SHARES:
        return max(0.0, change)
    if name in more and change > 0.0 and growths[name] > 0.0:
        return change * max(0.0, more[name]) / growths[name]
    return change


def _moved(family: Family, measured: Mapping[str, float], alone: Mapping[str, float]) -> bool:
    """Whether direct measures of a family were recorded and moved in its direction, by a part of what moved most."""
    if family is Family.OFFSET and any(abs(alone.get(name, 0.0)) > CONTRADICTED for name in _WITH_A_LOAD):
        return False  # the motion itself changed
    if family is Family.PLAY and not any(name in alone or name in measured for name in DIRECT[family]):
        return _lost_preload(alone)
    signs = DIRECTIONS[family]
    part = {name: _part(measured[name], signs[name]) for name in DIRECT[family] if name in measured}
    return _squared(part) > max(CONTRADICTED, PART * max(map(abs, alone.values()))) ** 2


def _lost_preload(alone: Mapping[str, float]) -> bool:
    """Whether effort fell by not much less than anything else rose, and all that play does is beyond chance.

    A machine that moves with less effort lags less, which counts at most as far as its effort fell. One that moves with
    more and lags more has lost no preload, whatever its effort at rest.
    """
    if min(alone.get("friction", 0.0), alone.get("lag", np.inf)) > CONTRADICTED:
        return False
    fallen = {name: _part(alone.get(name, 0.0), (-1,)) for name in ("friction", "settling", "lag")}
    rest = [abs(change) for name, change in alone.items() if not fallen.get(name)]
    of_effort = _squared({**fallen, "lag": 0.0})
    fell = of_effort + min(of_effort, fallen["lag"] ** 2)
    by_play = {name: _part(alone[name], its) for name, its in DIRECTIONS[Family.PLAY].items() if name in alone}
    return fell > max([LIKELY, *(MOSTLY * change for change in rest)]) ** 2 and _squared(by_play) > CONTRADICTED**2


def _explains_most(family: Family, alone: Mapping[str, float]) -> bool:
    """Whether a family explains the feature that changed most."""
    most = max(alone, key=lambda name: abs(alone[name]))
    ways = [*DIRECTIONS[family].get(most, ()), *_BESIDE.get(family, {}).get(most, ())]
    ways += [way for follower, its, _ in _FOLLOWING.get(family, ()) if follower == most for way in its]
    return any(way * alone[most] > 0.0 for way in ways)


def _part(change: float, ways: Collection[int]) -> float:
    """The part of a change that is in one of these directions."""
    return max(0.0, *(way * change for way in ways))


def _explanation(family: Family, values: Mapping[str, float]) -> _Explanation:
    """What the directions of a family explain."""
    signs = {name: signs for name, signs in DIRECTIONS[family].items() if name in values}
    part = {name: _part(values[name], its) for name, its in signs.items()}
    for follower, ways, leader in _FOLLOWING.get(family, ()):
        if follower in values and leader in part:
            follows = min(part[leader], _part(values[follower], ways))
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


def _unknown(values: Mapping[str, float], alone: Mapping[str, float], best: _Explanation | None) -> _Explanation:
    """The unknown: it explains what the best family leaves, and pays for both directions of every feature."""
    left = {name: abs(change) for name, change in values.items()} if best is None else best.left
    cost = _AKAIKE * (2 * len(values) - (0 if best is None else best.directions))
    told = {name: abs(change) for name, change in alone.items()} if best is None else left
    gained = _squared(left)
    if best is not None:
        gained /= 1.0 + (1.0 - MOSTLY) * _squared(values) / max(cost, _AKAIKE)
    return _Explanation(
        Family.UNKNOWN,
        (0.0 if best is None else best.explained) + gained - cost,
        2 * len(values),
        {},
        tuple(name for name in sorted(told, key=lambda name: -told[name]) if told[name] > LIKELY),
    )


def _squared(changes: Mapping[str, float]) -> float:
    """The squared size of a change."""
    return sum(change**2 for change in changes.values())
