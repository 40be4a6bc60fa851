"""A short stretch of a recording that decides an RMSE: what happens there outweighs all other samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ema_bench_replay.long_columns import pieces

from ..criteria import MOSTLY, SMALL

_PARTS = 200  # equal parts of a recording, of which a stretch consists


@dataclass(frozen=True)
class DecisiveStretch:
    """Where most of the squared error of a signal is in one recording; times [s] since its first sample."""

    begin: float
    end: float
    of_samples: float  # share of the recording's samples
    of_squares: float  # share of the recording's sum of squared errors


def decisive_stretch(residual: np.ndarray, time: np.ndarray) -> DecisiveStretch | None:
    """The shortest stretch that holds ``MOSTLY`` of a squared residual (n,); None if it is no ``SMALL`` share of it.

    ``time`` [s] (n,) rises. A recording of few samples has none.
    """
    if len(time) < _PARTS:
        return None
    edges = np.linspace(0, len(time), _PARTS + 1).astype(int)
    sums = np.concatenate([[0.0], np.cumsum(_squares(residual, edges))])
    if not 0.0 < sums[-1] < np.inf:
        return None
    first, last = _shortest(sums, MOSTLY * sums[-1])
    if last - first > SMALL * _PARTS:
        return None
    begin, end = (float(time[min(edges[k], len(time) - 1)]) for k in (first, last))
    return DecisiveStretch(begin, end, (last - first) / _PARTS, float((sums[last] - sums[first]) / sums[-1]))


def _squares(residual: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Sum of squares of a residual (n,) in each part between ``edges`` (p + 1,); samples without a value count as 0."""
    total = np.zeros(len(edges) - 1)
    for rows in pieces(len(residual)):
        part = np.searchsorted(edges, np.arange(rows.start, rows.stop), side="right") - 1
        with np.errstate(over="ignore"):  # of a twin that diverged
            total += np.bincount(part, np.nan_to_num(residual[rows]) ** 2, len(total))
    return total


def _shortest(sums: np.ndarray, wanted: float) -> tuple[int, int]:
    """(first, last) of the fewest parts that hold ``wanted``, from the running ``sums`` (p + 1,) of all parts."""
    firsts = np.arange(len(sums))
    lasts = np.searchsorted(sums, sums + wanted)
    best = int(np.argmin(np.where(lasts < len(sums), lasts - firsts, len(sums))))
    return best, int(lasts[best])
