"""Test whether an angle of a user's effect is the phase of a wave, so that two of its values determine all others."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

from ..effects.effect import Effect, Parameter
from ..plant.operating_point import OperatingPoint
from .trial import POINTS, choices

_TURNED = (0.7, 2.1, 4.0)
"""Test angles, rad: a wave must be the combination of its values at two angles a quarter turn apart."""
_SAME = 1e-6  # tolerance, relative to the largest value


@lru_cache
def turns_a_wave(effect: Effect, parameter: Parameter) -> bool:
    """Whether ``act`` is a sum of a constant and multiples of cosine and sine of this angle."""
    return effect.act is not None and all(
        _is_wave(effect, effect.act, parameter, (*numeric,), at) for numeric in _numeric(effect) for at in POINTS
    )


def _numeric(effect: Effect) -> list[tuple[float, ...]]:
    if effect.option_value is None:
        return [()]
    return [(float(effect.option_value(options)),) for options in choices(effect)]


def _is_wave(
    effect: Effect,
    act: Callable[..., float],
    parameter: Parameter,
    numeric: tuple[float, ...],
    at: OperatingPoint,
) -> bool:
    def value(angle: float) -> float:
        return float(act(at, (*{**effect.default_parameters(), parameter.name: angle}.values(), *numeric)))

    try:
        plain, quarter, half = value(0.0), value(0.5 * math.pi), value(math.pi)
        middle = 0.5 * (plain + half)
        wave = [middle + (plain - middle) * math.cos(a) + (quarter - middle) * math.sin(a) for a in _TURNED]
        off = max(abs(value(a) - told) for a, told in zip(_TURNED, wave, strict=True))
    except Exception:  # plain Python is stricter than compiled code: then each angle is tried
        return False
    return off <= _SAME * max(abs(plain), abs(quarter), abs(half), abs(middle))
