"""Columns that only number the rows of a trace: they rise by the same step in every row, as nothing measured does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.traces.header_words import HeaderWords

from ..criteria import NEGLIGIBLE
from ..measured.way_by_speed import FEWEST
from .clock import is_uneven
from .column_quantity import has_word, word_quantity
from .column_words import SETPOINT, STEMS


def row_counters(
    names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray], time: HeaderWords | None
) -> tuple[str, ...]:
    """The names of columns that would be signals by their words and only number the samples beside a ``time``.

    A command may rise so, and a shaft that is named may turn so; what has a unit is no number of a row. Operating
    points, which have no even time, may be set so.
    """
    if time is None or time.name not in numbers or is_uneven(numbers[time.name]):
        return ()
    told = [read for read in names if read.unit is None and not read.foreign and word_quantity(read.words) is not None]
    told = [read for read in told if not has_word(read.words, f"{SETPOINT}|{STEMS['position']}")]
    return tuple(read.name for read in told if read is not time and _rises_evenly(numbers.get(read.name)))


def _rises_evenly(values: np.ndarray | None) -> bool:
    """Whether values (n,) rise by the same step, to the last digits, in each of enough rows."""
    if values is None or len(values) < FEWEST or not np.isfinite(values).all():
        return False
    steps = np.diff(values)
    return bool(steps[0] > 0.0 and np.abs(steps - steps[0]).max() <= NEGLIGIBLE**4 * steps[0])


def numbers_the_rows(values: np.ndarray) -> bool:
    """Whether values (n,) rise by one from row to row, as an index does, however uneven the time is."""
    return _rises_evenly(values) and float(values[1] - values[0]) == 1.0
