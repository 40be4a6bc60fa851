"""Bins of a quantity, for summarising a residual."""

from __future__ import annotations

import numpy as np


def bin_edges(x: np.ndarray, bins: int, *, narrow: bool) -> np.ndarray:
    """Edges (bins + 1,) over the values ``x`` (n,); ``narrow`` bins near zero for quantities with detail there."""
    if len(x) == 0:
        return np.linspace(0.0, 1.0, bins + 1)
    if not narrow:
        return np.linspace(x.min(), x.max(), bins + 1)
    root = np.sqrt(np.abs(x).max()) * np.linspace(-1.0, 1.0, bins + 1)
    return root * np.abs(root)


def rows_by_bin(x: np.ndarray, edges: np.ndarray, fewest: int) -> list[np.ndarray]:
    """Indices into ``x`` (n,) for each bin that has at least ``fewest``."""
    place = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(edges) - 2)
    rows = (np.flatnonzero(place == k) for k in range(len(edges) - 1))
    return [found for found in rows if len(found) >= fewest]


def quartiles(values: np.ndarray, rows: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lower quartiles, medians and upper quartiles (b,) of the finite values in each bin, as ``np.quantile`` has them.

    That function takes fifteen times as long for a few values, and a report has hundreds of bins.
    """
    found = np.zeros((3, len(rows)))
    for k, inside in enumerate(rows):
        ordered = np.sort(values[inside])
        place = np.array((0.25, 0.5, 0.75)) * (len(ordered) - 1)
        before = place.astype(int)
        after = np.minimum(before + 1, len(ordered) - 1)
        found[:, k] = ordered[before] + (place - before) * (ordered[after] - ordered[before])
    lower, median, upper = found
    return lower, median, upper
