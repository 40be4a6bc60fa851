"""Start values of a parameter's search: from its table, or spread over what the recordings cover.

A user's own effect need not give starts. If two starts are too far apart, a fit ends near the truth and reports it with
too much certainty. So angles are tried over a turn, positions over the travel of the output, and speeds, widths and
times by factors up to the largest that was recorded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..criteria import SMALL
from ..effects import Effect, Parameter
from ..effects.catalogue import is_own
from ..own_effects.wave import turns_a_wave
from .search_limits import Reached, search_limits

WIDE = 100.0  # ratio of bounds from which on a positive parameter is spaced by factors
SPREAD = 24  # starts of an effect with one shape parameter
FEWEST = 4  # of each of several shape parameters, and of one in which an effect is linear
MOST = 400  # starts of all shape parameters together
_TURNS = 4.0 * math.pi + 1.0  # rad, largest range of bounds that means an angle of a shaft: one turn, or two
DECADES = {"rad/s": 3.5, "rad": 3.0, "s": 3.0}
"""By unit: decades below the largest recorded value to which the search of a non-negative parameter goes. Speeds of the
slow shaft are that far below those of the fast one."""


def start_values(effect: Effect, parameter: Parameter, of: Reached) -> tuple[float, ...]:
    """The values of a parameter from which its search begins."""
    if parameter.starts:
        return parameter.starts
    if is_own(effect):
        return _covered(effect, parameter, of)
    if parameter.periodic:
        return (0.0, 0.5 * math.pi)
    if parameter.is_place:  # other than where the recordings begin
        apart = of.began[1] - of.began[0] > SMALL * (of.places[1] - of.places[0])
        return _linear(*of.places, FEWEST) if apart else ()
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
    # a position that was passed, or an angle of a part that turns several times
    if lower < 0.0 and parameter.unit == "rad":
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
    """The angle that a linear regression finds from two of its values; angles with starts are shape parameters."""
    angle = next((p for p in effect.parameters if p.periodic and not p.starts), None)
    return None if angle is not None and is_own(effect) and not turns_a_wave(effect, angle) else angle


def _count(effect: Effect) -> int:
    """Number of values of each shape parameter without starts: the more parameters, the fewer values of each."""
    angle = regressed_angle(effect)
    shapes = [p for k, p in enumerate(effect.parameters) if (k or p.neutral is None) and p is not angle]
    given = math.prod(len(p.starts) for p in shapes if p.starts)
    own = sum(not p.starts for p in shapes)
    return max(FEWEST, min(SPREAD, int((MOST / given) ** (1.0 / max(own, 1)))))


def _overlap(lower: float, upper: float, places: Sequence[float]) -> tuple[float, float]:
    """The part of the bounds that was passed; the bounds themselves if none was."""
    inside = max(lower, places[0]), min(upper, places[1])
    return inside if inside[0] < inside[1] else (lower, upper)


def _linear(lower: float, upper: float, count: int) -> tuple[float, ...]:
    return tuple(lower + (upper - lower) * (k + 0.5) / count for k in range(count))
