"""The steps of a counter, seen in its values."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..criteria import NEARLY_ALL, NEGLIGIBLE

_SHARES = (0.2, 0.05)  # of the steps between neighbouring values that may be single steps


def smallest_step(values: np.ndarray) -> float | None:
    """The step of which all differences between a counter's values (n,) are multiples; None if there is none.

    Also None if nearly all samples advance by exactly one such step: a shaft that turns steadily does so too. A shaft
    that turns fast shows single steps only where it reverses.
    """
    steps = np.diff(np.unique(values))
    for share in _SHARES if len(steps) else ():
        smallest = float(np.median(steps[steps <= 1.5 * np.quantile(steps, share)]))
        parts = steps / smallest
        if np.mean(np.rint(np.abs(np.diff(values)) / smallest) == 1.0) >= NEARLY_ALL:
            return None
        if float(np.quantile(np.abs(parts - np.rint(parts)), 0.9)) < 0.1:
            return smallest
    return None


def is_decimal(step: float, digits: Sequence[float] = (1.0, 2.0, 5.0)) -> bool:
    """Whether a step is one of these ``digits`` of a decimal place."""
    leading = step / 10.0 ** math.floor(math.log10(step) + NEGLIGIBLE)
    return any(abs(leading / digit - 1.0) < NEGLIGIBLE for digit in digits)
