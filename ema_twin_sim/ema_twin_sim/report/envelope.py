"""Reduce long curves to few points without losing a peak."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def envelope_rows(series: Sequence[np.ndarray], points: int) -> np.ndarray:
    """The indices at which curves (n,) are drawn together: where any of them is smallest or largest in its stretch.

    At most about ``points`` of them, in rising order, including the ends; all if there are no more. Samples that are
    not finite are ignored.
    """
    length = len(series[0])
    if length <= points:
        return np.arange(length)
    stretch = -(-length * 2 * len(series) // points)  # samples of a stretch, in which each curve has two extremes
    whole = -(-length // stretch) * stretch
    first = np.arange(0, length, stretch)
    chosen = [np.array([0, length - 1])]
    for values in series:
        for sign in (1.0, -1.0):
            padded = np.full(whole, -np.inf)
            padded[:length] = np.where(np.isfinite(values), sign * values, -np.inf)
            chosen.append(first + padded.reshape(-1, stretch).argmax(axis=1))
    return np.unique(np.concatenate(chosen))
