"""Power over orders (cycles per turn of an angle), however far that turns: a line is one over the turns wide.

A grid of orders that is coarser than a line would miss it, so each order of the grid stands for its cell, as far as
half way to its neighbours, and counts the largest power in there; where in the cell that is, ``refined`` tells.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

_ANGLE_BINS = 512  # per turn: orders up to 256
_LARGEST = 1 << 22  # angle bins of one transform, which then takes some 0.4 GB
_FINER = 8  # orders tried within the width of a line


def largest_in_cells(
    orders: np.ndarray, residual: np.ndarray, angle: np.ndarray, fewest_cycles: float = 0.0
) -> np.ndarray:
    """The largest power (m,) of a residual (n,) over an angle (n,) [rad] in the cell of each of evenly spaced orders
    (m,): a wave's mean square times n. Zero where there are fewer cycles of an order.

    What turns too far for one transform is cut into pieces by its angle, whose powers add.
    """
    power = np.zeros(len(orders))
    residual = residual - residual.mean()  # or a constant error would leak into low orders
    for rows, turns in _pieces(angle):
        found = _in_cells(orders, residual[rows], angle[rows])
        power += np.where(orders * turns >= fewest_cycles, found, 0.0)
    return power


def refined(order: float, step: float, parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> float:
    """The order of most power within half a step of one, to an eighth of a line's width.

    Of parts (residual, angle [rad]), each (n,), whose powers add.
    """
    longest = line_turns([angle for _, angle in parts])
    half = max(1, math.ceil(0.5 * step * _FINER * longest))
    near = 0.5 * step * np.arange(-half, half + 1) / half
    power = np.zeros(len(near))
    for residual, angle in parts:
        residual = residual - residual.mean()
        for rows, turns in _pieces(angle):
            # what is within half a step of the order turns slowly beside it: sums over its boxes of angle tell that
            boxes = math.ceil(_FINER * step * turns) + 1
            from_start = angle[rows] - angle[rows].min()
            box = np.minimum((from_start * (boxes / (2.0 * np.pi * turns))).astype(np.int64), boxes - 1)
            wave = residual[rows] * np.exp(-1j * order * from_start)
            sums = np.bincount(box, wave.real, boxes) + 1j * np.bincount(box, wave.imag, boxes)
            centres = (np.arange(boxes) + 0.5) * (2.0 * np.pi * turns / boxes)
            power += np.abs(np.exp(-1j * np.outer(near, centres)) @ sums) ** 2 / len(from_start)
    return order + float(near[int(np.argmax(power))])


def line_turns(angles: Sequence[np.ndarray]) -> float:
    """Turns of the longest piece of the angles, each (n,) [rad], that one transform takes: a line is 1 / turns wide."""
    return max(turns / count for turns, count in map(_turns, angles))


def _turns(angle: np.ndarray) -> tuple[float, int]:
    """Turns of an angle, and the pieces into which it is cut."""
    turns = float(np.ptp(angle)) / (2.0 * math.pi) + 1.0 / _ANGLE_BINS
    return turns, math.ceil(turns * _ANGLE_BINS / _LARGEST)


def _pieces(angle: np.ndarray) -> Iterator[tuple[np.ndarray | slice, float]]:
    """(rows, turns) of each piece of an angle that one transform takes; empty ones are left out."""
    turns, count = _turns(angle)
    if count == 1:
        yield slice(None), turns
        return
    piece = ((angle - angle.min()) * (count / (2.0 * math.pi * turns))).astype(np.int64)
    for k in range(count):
        rows = np.flatnonzero(piece == k)
        if len(rows):
            yield rows, turns / count


def _in_cells(orders: np.ndarray, residual: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """The largest power in each cell, by one transform."""
    place = np.floor(angle * (_ANGLE_BINS / (2.0 * math.pi))).astype(np.int64)
    place -= place.min()
    bins = int(place.max()) + 1
    length = 1 << max(12, (4 * bins - 1).bit_length())
    spectrum = np.abs(np.fft.rfft(np.bincount(place, residual, bins), length)) ** 2 * (2.0 / len(residual))
    apart = _ANGLE_BINS / length
    at_centre = np.interp(orders, np.arange(len(spectrum)) * apart, spectrum)
    step = orders[1] - orders[0]
    edges = np.ceil(np.append(orders - 0.5 * step, orders[-1] + 0.5 * step) / apart).astype(np.int64)
    inside = np.maximum.reduceat(spectrum, edges)[:-1]
    return np.maximum(at_centre, np.where(edges[1:] > edges[:-1], inside, 0.0))
