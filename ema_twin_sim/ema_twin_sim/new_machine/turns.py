"""Unwrap positions whose column starts again after each turn or another period, before anything judges them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS
from ema_bench_replay.traces.wrapped_angle import counted_on, unwrapped
from ema_bench_replay.units import units_of

from .columns import Guess, Guesses
from .usual_counts import usual_counts
from .wrap_period import wrap_period


def counted_on_turns(guesses: Guesses, numbers: Mapping[str, np.ndarray]) -> tuple[Guesses, dict[str, np.ndarray]]:
    """The guesses, with the counts per turn that a wrapping counter shows, and the unwrapped numbers (n,)."""
    if guesses.motion != "rotary":
        return guesses, dict(numbers)
    on, signals = dict(numbers), []
    for guess in guesses.signals:
        if guess.signal in ("motor_position", "output_position"):
            guess, on[guess.column] = _counted_on(guess, numbers[guess.column])
        signals.append(guess)
    return replace(guesses, signals=tuple(signals)), on


def _counted_on(guess: Guess, values: np.ndarray) -> tuple[Guess, np.ndarray]:
    """The guess, with unit, counts or the period if its numbers show them, and the unwrapped numbers (n,)."""
    by_turn, on, turns = _by_one_turn(guess, values)
    if turns:
        return by_turn, on
    units = units_of("motor_position")
    period = wrap_period(values, 2.0 * np.pi / units[guess.unit] if guess.unit in units else None)
    if period is None:
        return guess, values
    on, _ = unwrapped(values, period)
    return replace(guess, wraps_after=period), on


def _by_one_turn(guess: Guess, values: np.ndarray) -> tuple[Guess, np.ndarray, int]:
    """The same if the position starts again after each turn, and how often it does."""
    units = units_of("motor_position")
    if guess.unit is None:
        for unit in ("deg", "rad", "rev"):
            turn = 2.0 * np.pi / units[unit]
            on, turns = counted_on(values, turn)
            if turns:
                return replace(guess, unit=unit, doubt=f"no unit in the header; it wraps after {turn:.4g}"), on, turns
    if guess.unit in units:
        return guess, *counted_on(values, 2.0 * np.pi / units[guess.unit])
    counts = guess.counts or usual_counts(float(np.ptp(values)) + 1.0)
    if guess.unit != COUNTS or counts is None:
        return guess, values, 0
    return replace(guess, counts=counts), *counted_on(values, counts)
