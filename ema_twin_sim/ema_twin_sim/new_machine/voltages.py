"""Columns that may stand for the motor's torque if neither that nor a current was found."""

from __future__ import annotations

from ema_bench_replay.traces.header_words import header_words

from .column_quantity import has_word
from .column_words import DUTY, DUTY_SETTING
from .columns import Guesses


def voltages(guesses: Guesses) -> list[str]:
    """The names of the columns that are a voltage, then of those that are a duty cycle."""
    found = [guess.column for guess in guesses.signals if guess.signal == "voltage"]
    left = [(name, header_words(name)) for name in guesses.left]
    return [
        *found,
        *(name for name, read in left if has_word(read.words, DUTY) and not has_word(read.words, DUTY_SETTING)),
    ]
