"""Unwrap positions whose column starts again after each turn, before they are compared with anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS
from ema_bench_replay.traces.wrapped_angle import counted_on
from ema_bench_replay.units import units_of

from .columns import Guess, Guesses
from .usual_counts import usual_counts


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
    """The guess, with unit or counts if its numbers show them, and the unwrapped numbers (n,)."""
    units = units_of("motor_position")
    if guess.unit is None:
        for unit in ("deg", "rad", "rev"):
            turn = 2.0 * np.pi / units[unit]
            on, turns = counted_on(values, turn)
            if turns:
                return replace(guess, unit=unit, doubt=f"no unit in the header; it wraps after {turn:.4g}"), on
    if guess.unit in units:
        return guess, counted_on(values, 2.0 * np.pi / units[guess.unit])[0]
    counts = guess.counts or usual_counts(float(np.ptp(values)) + 1.0)
    if guess.unit != COUNTS or counts is None:
        return guess, values
    on, turns = counted_on(values, counts)
    return (replace(guess, counts=counts), on) if turns else (guess, values)
