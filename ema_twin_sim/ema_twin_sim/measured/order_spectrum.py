"""Power over orders (cycles per turn of an angle); a spectral line is 1 / turns wide.

A grid of orders coarser than a line would miss it. So each order of the grid stands for its cell, half way to its
neighbours, and gets the largest power inside; ``refined`` finds where in the cell that is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ema_bench_replay.long_columns import by_pieces, extremes, mean_of, pieces, release_pages

_ANGLE_BINS = 512  # per turn: orders up to 256
_LARGEST = 1 << 22  # angle bins of one transform, which then needs about 0.4 GB
_LEAST = 4096  # bins of a transform, so that its orders lie close enough to be read between
_FINER = 8  # orders tried within the width of a line


def largest_in_cells(
    orders: np.ndarray, residual: np.ndarray, angle: np.ndarray, fewest_cycles: float = 0.0
) -> np.ndarray:
    """Largest power (m,) of a residual (n,) over an angle (n,) [rad], in the cells of evenly spaced orders (m,).

    The power of a wave is its mean square times n. It is zero for an order with fewer than ``fewest_cycles``. An angle
    too long for one transform is cut into pieces, whose powers add.
    """
    power = np.zeros(len(orders))
    mean = mean_of(residual)  # otherwise a constant error would leak into low orders
    for cut in _cuts(angle):
        power += np.where(orders * cut.turns >= fewest_cycles, _in_cells(orders, residual, mean, angle, cut), 0.0)
    return power


def refined(order: float, step: float, parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> float:
    """Order with the most power within half a step of ``order``, to an eighth of a line width.

    ``parts`` are pairs (residual, angle [rad]), each (n,), whose powers add.
    """
    longest = line_turns([angle for _, angle in parts])
    half = max(1, math.ceil(0.5 * step * _FINER * longest))
    near = 0.5 * step * np.arange(-half, half + 1) / half
    power = np.zeros(len(near))
    for residual, angle in parts:
        mean = mean_of(residual)
        for cut in _cuts(angle):
            # After demodulation by the order, what remains within half a step varies slowly: sums over boxes of angle
            # suffice.
            boxes = math.ceil(_FINER * step * cut.turns) + 1
            sums = np.zeros(boxes, complex)
            for rows in cut.rows():
                from_start = angle[rows] - cut.least
                box = np.minimum((from_start * (boxes / (2.0 * np.pi * cut.turns))).astype(np.int64), boxes - 1)
                wave = (residual[rows] - mean) * np.exp(-1j * order * from_start)
                sums += np.bincount(box, wave.real, boxes) + 1j * np.bincount(box, wave.imag, boxes)
            centres = (np.arange(boxes) + 0.5) * (2.0 * np.pi * cut.turns / boxes)
            power += np.abs(np.exp(-1j * np.outer(near, centres)) @ sums) ** 2 / cut.count
    return order + float(near[int(np.argmax(power))])


def line_turns(angles: Sequence[np.ndarray]) -> float:
    """Turns of the longest piece of the angles (n,) [rad] that one transform takes: a line is 1 / turns wide."""
    return max(turns / count for turns, count in (_turns(*extremes(angle)) for angle in angles))


@dataclass(frozen=True)
class _Cut:
    """The part of an angle that one transform takes: all of it, or a range between two angles."""

    turns: float
    count: int  # samples
    least: float  # rad, of these
    greatest: float
    rows: Callable[[], Iterator[np.ndarray | slice]]  # which rows these are, piece by piece


def _turns(least: float, greatest: float) -> tuple[float, int]:
    """Turns between two angles [rad], and the number of cuts they need."""
    turns = (greatest - least) / (2.0 * math.pi) + 1.0 / _ANGLE_BINS
    return turns, math.ceil(turns * _ANGLE_BINS / _LARGEST)


def _cuts(angle: np.ndarray) -> Iterator[_Cut]:
    """The cuts of an angle (n,) [rad]; empty ones are left out."""
    least, greatest = extremes(angle)
    turns, count = _turns(least, greatest)
    if count == 1:
        yield _Cut(turns, len(angle), least, greatest, partial(pieces, len(angle)))
        return
    number = by_pieces(lambda part: ((part - least) * (count / (2.0 * math.pi * turns))).astype(np.int64), angle)
    spans = [(rows, extremes(number[rows])) for rows in pieces(len(number))]

    def rows_of(k: int) -> Iterator[np.ndarray]:
        for rows, (first, last) in spans:
            if first <= k <= last:
                yield rows.start + np.flatnonzero(number[rows] == k)
                release_pages()

    for k in range(count):
        ends = [(len(rows), *extremes(angle[rows])) for rows in rows_of(k) if len(rows)]
        if ends:
            samples, lows, highs = zip(*ends, strict=True)
            yield _Cut(turns / count, sum(samples), min(lows), max(highs), partial(rows_of, k))


def _in_cells(orders: np.ndarray, residual: np.ndarray, mean: np.floating, angle: np.ndarray, cut: _Cut) -> np.ndarray:
    """The largest power in each cell, by one transform."""
    per_radian = _ANGLE_BINS / (2.0 * math.pi)
    first, last = (math.floor(end * per_radian) for end in (cut.least, cut.greatest))
    bins = last - first + 1
    sums = np.zeros(bins)
    for rows in cut.rows():
        place = np.floor(angle[rows] * per_radian).astype(np.int64) - first
        sums += np.bincount(place, residual[rows] - mean, bins)
    length = _fast_length(max(_LEAST, 4 * bins))
    spectrum = np.abs(np.fft.rfft(sums, length)) ** 2 * (2.0 / cut.count)
    apart = _ANGLE_BINS / length
    at_centre = np.interp(orders, np.arange(len(spectrum)) * apart, spectrum)
    step = orders[1] - orders[0]
    edges = np.ceil(np.append(orders - 0.5 * step, orders[-1] + 0.5 * step) / apart).astype(np.int64)
    inside = np.maximum.reduceat(spectrum, edges)[:-1]
    return np.maximum(at_centre, np.where(edges[1:] > edges[:-1], inside, 0.0))


def _fast_length(least: int) -> int:
    """The smallest length of at least so many bins that is a power of two, or three or five times one.

    That of ``scipy.fft`` would cost most programs more time to import than it saves.
    """
    return min(times << max(0, ((least - 1) // times).bit_length()) for times in (1, 3, 5))
