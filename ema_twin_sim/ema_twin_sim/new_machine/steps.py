"""The steps of a counter, seen in its values."""

from __future__ import annotations

import numpy as np

from ..criteria import NEARLY_ALL


def smallest_step(values: np.ndarray) -> float | None:
    """The step of which all differences between a counter's values (n,) are multiples; None if there is none.

    Also None if nearly all samples advance by exactly one such step: a shaft that turns steadily does so too.
    """
    steps = np.diff(np.unique(values))
    if not len(steps):
        return None
    smallest = float(np.median(steps[steps <= 1.5 * np.quantile(steps, 0.2)]))
    parts = steps / smallest
    if np.mean(np.rint(np.abs(np.diff(values)) / smallest) == 1.0) >= NEARLY_ALL:
        return None
    return smallest if float(np.quantile(np.abs(parts - np.rint(parts)), 0.9)) < 0.1 else None
