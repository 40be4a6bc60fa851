"""Columns of a power analyser that letters alone name, such as ``S1`` beside ``P1`` and ``Q1``: no motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations, product

import numpy as np

from ema_bench_replay.traces.header_words import HeaderWords

from ..criteria import NEGLIGIBLE

_LETTERS: dict[str, tuple[str | None, ...]] = {
    "v": (None, "voltage"),
    "u": (None, "voltage"),
    "i": (None, "current"),
    "p": (None,),
    "q": (None,),
    "s": (None,),
}
"""The letters that name an analyser's columns, and the quantities that their units may tell (none: of a power)."""
_PHASES = (1.0, math.sqrt(3.0), 3.0)
"""Apparent power over voltage times current: of one phase, and of three by the voltage between lines or to neutral."""


def analysers_columns(
    names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]
) -> dict[tuple[str, ...], tuple[str, ...]]:
    """The columns of voltages and powers by the words that they share, such as ``sigma`` or the number of a phase.

    Their numbers (n,) show it: S² = P² + Q², or S is the voltage times the current. The current is none of them: it is
    the motor's if nothing else is.
    """
    families: dict[tuple[str, ...], dict[str, HeaderWords]] = {}
    for read in names:
        for letter in {*read.words} & _LETTERS.keys():
            if read.quantity in _LETTERS[letter] and read.name in numbers:
                rest = tuple(word for word in read.words if word != letter)
                families.setdefault(rest, {})[letter] = read
    return {
        rest: tuple(read.name for letter, read in family.items() if letter != "i")
        for rest, family in families.items()
        if _is_electrical({letter: numbers[read.name] for letter, read in family.items()})
    }


def _is_electrical(family: Mapping[str, np.ndarray]) -> bool:
    """Whether columns (n,) with these letters give the same apparent power in two ways."""
    measured = [family["s"]] if "s" in family else []
    from_powers = [np.hypot(family["p"], family["q"])] if {"p", "q"} <= family.keys() else []
    voltages = [family[letter] for letter in ("v", "u") if letter in family and "i" in family]
    from_voltage = [times * np.abs(voltage * family["i"]) for voltage in voltages for times in _PHASES]
    ways = combinations((measured, from_powers, from_voltage), 2)
    return any(_agree(*pair) for one, other in ways for pair in product(one, other))


def _agree(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two powers (n,) are the same but for next to nothing; False if there are none."""
    known = np.isfinite(one) & np.isfinite(other)
    size = float(np.linalg.norm(one[known]))
    return size > 0.0 and float(np.linalg.norm(one[known] - other[known])) < NEGLIGIBLE * size
