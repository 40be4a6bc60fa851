"""Unwrap positions that start again after each turn, as absolute encoders show them, or after another period."""

from __future__ import annotations

import numpy as np

from ema_bench_replay.long_columns import Column, by_pieces, extremes, overlapping, steps_where

_LEAST_SPAN = 0.75  # of a turn: minimum span of a wrapping angle
_MOST_SPAN = 1.001  # of a turn: its maximum span
_JUMP = 0.5  # of a turn between two samples: no motor turns that far in one sample of a drive
_MOST_JUMPS = 0.25  # of all steps


def counted_on(values: np.ndarray, turn: float) -> tuple[np.ndarray, int]:
    """The unwrapped angle (n,), and the number of wraps; ``turn`` is one turn in the same unit.

    An angle that exceeds one turn, never jumps, or jumps too often, is returned unchanged.
    """
    known = by_pieces(lambda part: part[np.isfinite(part)], values)
    if len(known) < 2:
        return values, 0
    jumps = _jumps(known, turn)
    least, greatest = extremes(known)
    if not 0 < jumps <= _MOST_JUMPS * len(known) or not _LEAST_SPAN * turn < greatest - least <= _MOST_SPAN * turn:
        return values, 0
    return unwrapped(values, turn)


def unwrapped(values: np.ndarray, period: float) -> tuple[np.ndarray, int]:
    """A position (n,) that starts again after each ``period``, in its own unit, counted on; second, how often it did.

    A step of more than half a period is taken for a new start, whatever it looks like.
    """
    known = by_pieces(lambda part: part[np.isfinite(part)], values)
    jumps = _jumps(known, period) if len(known) > 1 else 0
    if not jumps:
        return values, 0
    went = Column(np.float64)
    more = 0.0  # offset of the unwrapped angle at the end of the previous piece
    for part in overlapping(known):
        on = np.unwrap(part, period=period) + more
        went.add(on[1:] if went.size else on)  # each later piece begins with the previous one's last value
        more = on[-1] - part[-1]
    whole = went.finish()
    if len(known) == len(values):
        return whole, jumps
    on = values.astype(float)
    on[np.isfinite(values)] = whole
    return on, jumps


def _jumps(known: np.ndarray, period: float) -> int:
    """In how many steps a position (n,) goes farther than half a period."""
    return len(steps_where(lambda steps: np.abs(steps) > _JUMP * period, known))
