"""Angles that begin again after each turn, as absolute encoders show them: counted on."""

from __future__ import annotations

import numpy as np

_LEAST_SPAN = 0.75  # of a turn, that an angle which begins again has been through
_MOST_SPAN = 1.001  # of a turn
_JUMP = 0.5  # of a turn between two samples: no motor goes so far in one of a drive's
_MOST_JUMPS = 0.25  # of all steps


def counted_on(values: np.ndarray, turn: float) -> tuple[np.ndarray, int]:
    """The angle (n,) as the shaft went, and how often it began again; ``turn`` is one turn in the same unit.

    An angle that goes beyond one turn, or does not jump, or does so all the time, stays as it is.
    """
    finite = np.isfinite(values)
    if finite.sum() < 2:
        return values, 0
    known = values[finite]
    jumps = int(np.count_nonzero(np.abs(np.diff(known)) > _JUMP * turn))
    if not 0 < jumps <= _MOST_JUMPS * len(known) or not _LEAST_SPAN * turn < np.ptp(known) <= _MOST_SPAN * turn:
        return values, 0
    on = values.astype(float)
    on[finite] = np.unwrap(known, period=turn)
    return on, jumps
