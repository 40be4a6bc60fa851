"""Distances that columns cover in the same parts of a recording, compared; and the size of a position's unit."""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS
from ema_bench_replay.units import units_of

from ..measured.way_by_speed import steady_factor
from .columns import Guess

_PARTS = 40  # parts of a recording whose distances are compared
_FEWEST = 8  # number of parts that must be long enough


def differences(*ways: np.ndarray) -> list[np.ndarray]:
    """Distances that motions (n,) cover in the parts of a recording."""
    lag = max(1, len(ways[0]) // _PARTS)
    return [way[lag:] - way[:-lag] for way in ways]


def steady(way: np.ndarray, expected: np.ndarray) -> float | None:
    """The factor between a distance and the expected one; None if it is not steady."""
    return steady_factor(way, expected, _FEWEST)


def is_open(guess: Guess) -> bool:
    """Whether the size in rad of 1 in a position's column is unknown."""
    return guess.unit is None or (guess.unit == COUNTS and guess.counts is None)


def radians(guess: Guess) -> float:
    """The size in rad of 1 in a position's column."""
    if guess.unit == COUNTS and guess.counts:
        return 2.0 * math.pi / guess.counts
    return units_of("motor_position")[guess.unit or "rad"]
