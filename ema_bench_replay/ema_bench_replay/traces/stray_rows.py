"""Rows of a trace that lie out of order by themselves: without them its time goes on as if they were not there.

Such a row comes from a cell that was mistyped or torn in transfer, or was written late. Where a second run begins,
time goes on from the earlier value instead.
"""

from __future__ import annotations

import numpy as np

from ema_bench_replay.long_columns import less_rows, steps_where

_MOST = 0.01  # share of rows; if more lie out of order, the rows are shuffled, or clocks take turns


def stray_rows(stamps: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Rows (k,) without which the stamps (n,) [ns] never go back; none if they cannot be told one by one.

    ``back`` (m,) are the rows whose stamps are earlier than those of the rows before them. The stray one is that row,
    if the row after it follows the row before it, or else the row before it, whose stamp is then too late.
    """
    none = back[:0]
    if back.size > max(1.0, _MOST * len(stamps)):
        return none
    found = []
    for row in back.tolist():
        if row + 1 == len(stamps) or stamps[row + 1] >= stamps[row - 1]:
            found.append(row)
        elif row == 1 or stamps[row] >= stamps[row - 2]:
            found.append(row - 1)
        else:
            return none
    stray = np.unique(np.array(found, dtype=back.dtype))
    return none if steps_where(lambda steps: steps < 0, less_rows(stamps, stray)).size else stray
