"""Unwrap a clock that begins again: a counter of few bits, or the milliseconds of a second alone.

Across each fall, such a clock goes on by its usual step, if a round span is added. A new run in the same file may begin
anywhere; runs that are as long as a round span begin alike: at zero, or with the same first steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ema_bench_replay.long_columns import Column, extremes, median, overlapping, pieces, steps_where
from ema_bench_replay.traces.import_map import TIME_UNITS

_WORDS = (1 << 16, 1 << 24, 1 << 32)  # ticks after which a counter begins again
_ROUND = (0.001, 1.0, 60.0, 3600.0, 86400.0)  # s after which a part of a clock time does
_USUAL = 0.5, 1.5  # times the usual step: a step across a fall, if no sample is lost there


class WrappedTime(NamedTuple):
    """Stamps [ns] (n,) counted on, the span [ns] after which the clock begins again, and the rows (m,) where it did."""

    stamps: np.ndarray
    span: int
    falls: np.ndarray


def unwrapped_time(stamps: np.ndarray, unit: str, first: float) -> WrappedTime | None:
    """The stamps [ns] (n,) of a clock in this unit of time counted on; None if no round span explains all its falls.

    ``first`` is what the clock shows at the first of them.
    """
    falls = steps_where(lambda steps: steps < 0, stamps) + 1
    if not falls.size:
        return None
    usual = median(lambda: map(np.diff, overlapping(stamps)))
    least, greatest = extremes(stamps)
    fallen = stamps[falls] - stamps[falls - 1]
    next_steps = np.take(stamps, falls + 1, mode="clip") - stamps[falls]
    alike = (stamps[falls] == stamps[0]).all() and (first == 0.0 or (next_steps == stamps[1] - stamps[0]).all())
    for span, is_word in _spans(unit):
        across = fallen + span
        fits = ((across > _USUAL[0] * usual) & (across < _USUAL[1] * usual)).all()
        if fits and greatest - least < span and (is_word or not alike):
            return WrappedTime(_counted_on(stamps, span, falls), span, falls)
    return None


def _spans(unit: str) -> list[tuple[int, bool]]:
    """Spans [ns] after which a clock in this unit may begin again, and whether it is a counter's word."""
    ticks = {TIME_UNITS[unit], TIME_UNITS["us"], TIME_UNITS["ms"]}
    words = {round(word * tick): True for word in _WORDS for tick in ticks}
    return sorted({**{round(span * TIME_UNITS["s"]): False for span in _ROUND}, **words}.items())


def _counted_on(stamps: np.ndarray, span: int, falls: np.ndarray) -> np.ndarray:
    """Stamps (n,) that are later by one span after each of the falls (m,)."""
    on = Column(np.int64)
    for rows in pieces(len(stamps)):
        wraps = np.searchsorted(falls, np.arange(rows.start, rows.stop), side="right")
        on.add(stamps[rows] + span * wraps)
    return on.finish()
