"""Whether the steps of a time are those of a clock that samples: nearly all of about the same length."""

from __future__ import annotations

import numpy as np

from ..criteria import MOSTLY

_CLOCKED = 2.0  # a clock's time steps are between the usual step over this and times this


def is_uneven(time: np.ndarray) -> bool:
    """Whether many steps of a time (n,) are far from the usual one; a clock that only drops some samples has few.

    False with fewer than two steps, which show no usual one.
    """
    steps = np.diff(time)
    if len(steps) < 2:
        return False
    usual = float(np.median(steps))
    if usual <= 0.0:
        return False
    return float(np.mean((steps > usual / _CLOCKED) & (steps < _CLOCKED * usual))) < MOSTLY
