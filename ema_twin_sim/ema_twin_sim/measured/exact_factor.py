"""Whether a signal is another one times a factor, to the last digits: then one of them was computed from the other."""

from __future__ import annotations

import numpy as np

from ..criteria import FEWEST_ROWS, NEGLIGIBLE


def exact_factor(values: np.ndarray, of: np.ndarray) -> float | None:
    """The factor by which values (n,) are those ``of`` another signal (n,), to the last digits; None without one."""
    known = np.isfinite(values) & np.isfinite(of)
    values, of = values[known], of[known]
    if len(values) < FEWEST_ROWS or np.ptp(values) == 0.0 or not of.any():  # two constants tell nothing
        return None
    factor = float(of @ values / (of @ of))
    rest = values - factor * of
    return factor if rest @ rest <= NEGLIGIBLE**4 * float(np.sum((values - values.mean()) ** 2)) else None
