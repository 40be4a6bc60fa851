"""Where the search of a number begins: as its table says, else spread over what the recordings cover.

A user's own effect need not say where its numbers may lie. Between two starts that lie too far apart, a fit ends beside
the truth and is sure of it; so every angle is tried over the turn, every place over the way that the output went, every
speed, width and time by factors up to the largest that was recorded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..effects import Effect, Parameter
from ..effects.catalogue import is_own
from ..own_effects.wave import turns_a_wave
from .search_limits import Reached, search_limits

WIDE = 100.0  # ratio of bounds from which on a number that is never zero is moved by factors
SPREAD = 24  # starts of an effect's only shape
FEWEST = 4  # of each of several
MOST = 400  # starts of all its shapes together
_TURNS = 4.0 * math.pi + 1.0  # rad, of bounds that an angle of a shaft has: a turn, or two
DECADES = {"rad/s": 3.5, "rad": 3.0, "s": 3.0}
"""By unit, how far below the largest recorded value the search of a number goes that is never negative; the speeds of
the slow shaft are as far below those of the fast one."""


def start_values(effect: Effect, parameter: Parameter, of: Reached) -> tuple[float, ...]:
    """The values of a parameter from which its search begins."""
    if parameter.starts:
        return parameter.starts
    if is_own(effect):
        return _covered(effect, parameter, of)
    if parameter.periodic:
        return (0.0, 0.5 * math.pi)
    lower, upper = parameter.lower, parameter.upper
    if lower > 0.0 and upper / lower > WIDE:
        ratio = (upper / lower) ** (1.0 / 7.0)
        return tuple(lower * ratio**k for k in range(1, 7))
    return tuple(lower + (upper - lower) * share for share in (0.1, 0.3, 0.5, 0.7, 0.9))


def _covered(effect: Effect, parameter: Parameter, of: Reached) -> tuple[float, ...]:
    """Values over what the recordings cover, within the parameter's bounds."""
    if parameter is regressed_angle(effect):
        return (0.0, 0.5 * math.pi)
    count = _count(effect)
    if parameter.periodic:
        return tuple(2.0 * math.pi * k / count for k in range(count))
    lower, upper = search_limits(effect, parameter, of)
    if lower < 0.0 and parameter.unit == "rad":  # a place that was passed, or an angle of what turns several times
        passed = _overlap(lower, upper, of.places)
        everywhere = _linear(lower, upper, count) if upper - lower <= _TURNS and passed != (lower, upper) else ()
        return (*_linear(*passed, count), *everywhere)
    largest = {"rad/s": of.speed, "rad": of.places[1] - of.places[0], "s": of.duration}.get(parameter.unit, upper)
    most = min(upper, largest) if largest > max(lower, 0.0) else upper
    if not math.isfinite(most):
        most = max(abs(parameter.default), lower) * WIDE
    if lower >= 0.0 and parameter.unit in DECADES:
        least = max(lower, most * 10.0 ** -DECADES[parameter.unit])
        return tuple(float(v) for v in np.geomspace(least, most, count)) if least < most else (most,)
    if lower > 0.0 and most / lower > WIDE:
        return tuple(float(v) for v in np.geomspace(lower, most, count + 2)[1:-1])
    if lower < 0.0 and parameter.unit in DECADES:
        up = np.geomspace(most * 10.0 ** -DECADES[parameter.unit], most, count)
        return tuple(float(v) for v in (*-up[::-1], *up) if lower <= v <= upper)
    return _linear(max(lower, -most), most, count)


def regressed_angle(effect: Effect) -> Parameter | None:
    """The angle that a regression finds, since two of its values tell all others; angles with starts are shapes."""
    angle = next((p for p in effect.parameters if p.periodic and not p.starts), None)
    return None if angle is not None and is_own(effect) and not turns_a_wave(effect, angle) else angle


def _count(effect: Effect) -> int:
    """How many values of each shape are tried that has no starts of its own: the more shapes, the fewer of each."""
    angle = regressed_angle(effect)
    shapes = [p for k, p in enumerate(effect.parameters) if (k or p.neutral is None) and p is not angle]
    given = math.prod(len(p.starts) for p in shapes if p.starts)
    own = sum(not p.starts for p in shapes)
    return max(FEWEST, min(SPREAD, int((MOST / given) ** (1.0 / max(own, 1)))))


def _overlap(lower: float, upper: float, places: Sequence[float]) -> tuple[float, float]:
    """What of the bounds was passed; the bounds themselves where none of them was."""
    inside = max(lower, places[0]), min(upper, places[1])
    return inside if inside[0] < inside[1] else (lower, upper)


def _linear(lower: float, upper: float, count: int) -> tuple[float, ...]:
    return tuple(lower + (upper - lower) * (k + 0.5) / count for k in range(count))
