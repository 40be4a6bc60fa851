"""The steps of a counter, seen in its values."""

from __future__ import annotations

import numpy as np

from ..criteria import NEARLY_ALL


def smallest_step(values: np.ndarray) -> float | None:
    """The step that all differences of a counter's values (n,) are made of; None where they come in no steps.

    Nor where nearly all samples go by one such step: that is how a shaft goes that turns steadily.
    """
    steps = np.diff(np.unique(values))
    if not len(steps):
        return None
    smallest = float(np.median(steps[steps <= 1.5 * np.quantile(steps, 0.2)]))
    parts = steps / smallest
    if np.mean(np.rint(np.abs(np.diff(values)) / smallest) == 1.0) >= NEARLY_ALL:
        return None
    return smallest if float(np.quantile(np.abs(parts - np.rint(parts)), 0.9)) < 0.1 else None
