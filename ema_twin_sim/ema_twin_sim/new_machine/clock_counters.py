"""Columns that count time beside the time column: they rise at one rate throughout, at which no shaft always turns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ema_bench_replay.traces.header_words import COUNTS, HeaderWords
from ema_bench_replay.traces.wrapped_angle import unwrapped

from ..criteria import FEWEST_ROWS, SMALL
from .column_quantity import has_word, word_quantity
from .column_words import ENCODER, MOTOR, OUTPUT, SETPOINT, STEMS

_WORDS = f"{STEMS['position']}|{ENCODER}|{MOTOR}|{OUTPUT}|{SETPOINT}"
"""Words of what is no clock, however it goes."""


def clock_counters(
    names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray], time: HeaderWords | None
) -> tuple[str, ...]:
    """The names of counters that rise at the same rate throughout by the ``time``, though they may start again.

    What says that it is a position, or a shaft's, is none: a shaft may turn so.
    """
    if time is None or time.name not in numbers:
        return ()
    told = [read for read in names if read is not time and read.name in numbers and not has_word(read.words, _WORDS)]
    return tuple(
        read.name
        for read in told
        if (read.unit == COUNTS or (read.unit is None and word_quantity(read.words) == "time"))
        and _rises_with(numbers[time.name], numbers[read.name])
    )


def _rises_with(time: np.ndarray, counter: np.ndarray) -> bool:
    """Whether a counter (n,), counted on where it starts again, is a straight line over a time (n,) that rises.

    It may be off by one of its counts, and by a small part of a sample.
    """
    if len(counter) < FEWEST_ROWS or not np.isfinite(counter).all() or not (np.diff(time) > 0.0).all():
        return False
    if not (counter == np.rint(counter)).all() or np.ptp(counter) == 0.0:
        return False
    for on in _counted_on(counter):
        steps = np.diff(on)
        rate, start = np.polyfit(time - time[0], on, 1)
        off = np.abs(on - start - rate * (time - time[0])).max()
        if steps.min() >= 0.0 and off <= 1.0 + SMALL * float(np.median(steps)):
            return True
    return False


def _counted_on(counter: np.ndarray) -> Iterator[np.ndarray]:
    """A counter (n,) as it is, and counted on after the smallest binary or decimal word that holds its values."""
    yield counter
    most = float(np.ptp(counter))
    for base in (2.0, 10.0):
        on, times = unwrapped(counter, base ** (np.floor(np.log(most) / np.log(base)) + 1.0))
        if times:
            yield on
