"""Columns of long recordings: stored on disk and processed piece by piece, so that memory is bounded.

A recording of up to ``WHOLE`` samples is in memory, and its columns are processed as a whole. The columns of a longer
one are unnamed files in the folder for temporary files (``TMPDIR``), mapped into memory. They behave like other arrays,
but pages that were read count as the process's memory until ``release_pages``. Code that iterates with ``pieces`` needs
memory for one piece. Sums over several pieces may differ in their last digits from sums over the whole.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import math
import mmap
import os
import resource
import tempfile
import threading
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import BinaryIO

import numpy as np

from ema_bench_replay.errors import InputError

WHOLE = 1 << 21
"""Samples of the longest recording kept in memory: an hour at 500 Hz, for which ``compare`` needs 0.6 GiB."""
PIECE = 1 << 18
"""Samples per piece of a longer recording."""

_DRAWN = 64  # samples per random draw, to locate a quantile roughly
_SURE = 4  # bracket of the quantile's rank among the draws, in square roots of their number: at least eight std
_WIDER = 4  # factor by which the bracket grows if it misses

_mappings: weakref.WeakSet[mmap.mmap] = weakref.WeakSet()
_lock = threading.Lock()


def is_long(count: int) -> bool:
    """Whether so many samples are processed in pieces."""
    return count > WHOLE


def pieces(count: int, multiple: int = 1) -> Iterator[slice]:
    """Slices that cover so many samples: one up to ``WHOLE`` samples, otherwise one per piece.

    Each piece except the last has a ``multiple`` of so many samples; the last is at least half as long as the others.
    """
    if not is_long(count):
        yield slice(0, count)
        return
    length = max(1, PIECE // multiple) * multiple
    first = 0
    while first < count:
        last = first + length if count - first >= length + length // 2 else count
        yield slice(first, last)
        release_pages()
        first = last


def spread_pieces(count: int) -> list[slice]:
    """Evenly spaced pieces of so many samples, about ``WHOLE`` samples in total."""
    every = list(pieces(count))
    chosen = np.linspace(0, len(every) - 1, max(1, min(WHOLE // PIECE, len(every))))
    return [every[k] for k in chosen.round().astype(int)]


def release_pages() -> None:
    """Release the memory of pages read from columns on disk; they can be read again."""
    with _lock:
        mappings = list(_mappings)
    for mapping in mappings:
        mapping.madvise(mmap.MADV_DONTNEED)


class Column:
    """A growing column: in memory up to ``WHOLE`` values, on disk beyond."""

    def __init__(self, kind: np.dtype | type) -> None:
        self.size = 0
        self._kind = np.dtype(kind)
        self._values = np.empty(0, self._kind)
        self._file: BinaryIO | None = None

    def add(self, values: np.ndarray) -> None:
        """Append values (m,). Raises InputError if the disk is full."""
        size = self.size + len(values)
        if self._file is None and is_long(size):
            self._spill()
        if self._file is not None:
            _write(self._file, np.ascontiguousarray(values, self._kind))
        else:
            if len(self._values) < size:
                self._values.resize(size + size // 4, refcheck=False)
            self._values[self.size : size] = values
        self.size = size

    def add_same(self, value: float, count: int) -> None:
        """Append one value so many times."""
        for rows in pieces(count):
            self.add(np.full(rows.stop - rows.start, value, self._kind))

    def finish(self) -> np.ndarray:
        """The column (n,); read-only if it is on disk. Nothing may be added afterwards."""
        if self._file is None:
            self._values.resize(self.size, refcheck=False)
            return self._values
        try:
            with self._file as file:
                mapping = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except OSError as error:
            raise _cannot_store(error) from None
        with _lock:
            _mappings.add(mapping)
        return np.frombuffer(mapping, self._kind)

    def _spill(self) -> None:
        _allow_open_files()
        try:
            self._file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115 - closed once it is mapped
        except OSError as error:
            raise _cannot_store(error) from None
        _write(self._file, self._values[: self.size])
        self._values = np.empty(0, self._kind)


def by_pieces(function: Callable[..., np.ndarray], *columns: np.ndarray, margin: int = 0) -> np.ndarray:
    """Apply a function to columns (n,) piece by piece, and concatenate the results.

    With a ``margin`` the function sees so many samples on either side of each piece, and returns one value per sample.
    """
    count = len(columns[0])
    if not is_long(count):
        return function(*columns)
    made: Column | None = None
    for rows in pieces(count):
        seen = slice(max(rows.start - margin, 0), min(rows.stop + margin, count))
        values = function(*(column[seen] for column in columns))
        made = made or Column(values.dtype)
        made.add(values[rows.start - seen.start :][: rows.stop - rows.start] if margin else values)
    assert made is not None  # a long column has pieces
    return made.finish()


def joined(columns: Sequence[np.ndarray]) -> np.ndarray:
    """Columns one after another (n,)."""
    if not is_long(sum(map(len, columns))):
        return np.concatenate(columns)
    if len(columns) == 1:
        return columns[0]
    made = Column(columns[0].dtype)
    for column in columns:
        for rows in pieces(len(column)):
            made.add(column[rows])
    return made.finish()


def values_at(column: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The values (m,) of a column (n,) at some places (m,), in the order of these."""
    if not is_long(len(column)):
        return column[places]
    found = np.empty(len(places), column.dtype)
    order = np.argsort(places)
    for rows in pieces(len(column)):
        here = order[slice(*np.searchsorted(places, (rows.start, rows.stop), sorter=order))]
        found[here] = column[places[here]]
    return found


def overlapping(column: np.ndarray) -> Iterator[np.ndarray]:
    """The pieces of a column (n,), each preceded by the last value of the one before."""
    for rows in pieces(len(column)):
        yield column[max(rows.start - 1, 0) : rows.stop]


def times(column: np.ndarray, factor: float) -> np.ndarray:
    """A column (n,) times a number."""
    return by_pieces(lambda part: part * factor, column)


def divided(column: np.ndarray, divisor: float) -> np.ndarray:
    """A column (n,) divided by a number."""
    return by_pieces(lambda part: part / divisor, column)


def shifted(column: np.ndarray, way: float) -> np.ndarray:
    """A column (n,) plus a number."""
    return by_pieces(lambda part: part + way, column)


def slopes(values: np.ndarray, over: np.ndarray) -> np.ndarray:
    """As ``np.gradient`` of values (n,) over a strictly rising column (n,)."""
    return by_pieces(np.gradient, values, over, margin=1)


def differences(column: np.ndarray) -> np.ndarray:
    """As ``np.diff`` of a column (n,)."""
    return by_pieces(np.subtract, column[1:], column[:-1])


def mean_of(column: np.ndarray) -> np.floating:
    """The mean of a column (n,); NaN if it is empty."""
    total: np.floating = sum((np.sum(column[rows]) for rows in pieces(len(column))), np.float64(0.0))
    return total / len(column) if len(column) else np.float64(math.nan)


def extremes(column: np.ndarray) -> tuple[float, float]:
    """Minimum and maximum of a column (n,) ignoring NaN; NaN if there is no value."""
    least = greatest = np.nan
    for rows in pieces(len(column)) if len(column) else ():
        least = np.fmin(least, np.fmin.reduce(column[rows]))
        greatest = np.fmax(greatest, np.fmax.reduce(column[rows]))
    return float(least), float(greatest)


def places_where(condition: Callable[..., np.ndarray], *columns: np.ndarray) -> np.ndarray:
    """The indices (m,) in columns (n,) at which a condition holds."""
    of_pieces = pieces(len(columns[0]))
    return np.concatenate([r.start + np.flatnonzero(condition(*(column[r] for column in columns))) for r in of_pieces])


def steps_where(condition: Callable[[np.ndarray], np.ndarray], column: np.ndarray) -> np.ndarray:
    """The indices (m,) of the steps between neighbours in a column (n,) for which a condition holds."""
    return places_where(lambda later, earlier: condition(later - earlier), column[1:], column[:-1])


def less_rows(column: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """The column (n,) without some rows, given in ascending order."""
    if not is_long(len(column)):
        return np.delete(column, rows)
    made = Column(column.dtype)
    for piece in pieces(len(column)):
        made.add(np.delete(column[piece], rows[slice(*np.searchsorted(rows, (piece.start, piece.stop)))] - piece.start))
    return made.finish()


def joined_if_short(parts: Callable[[], Iterable[np.ndarray]]) -> Callable[[], Iterable[np.ndarray]]:
    """The parts for repeated iteration; joined into a single array if they are short together."""
    arrays = [np.zeros(0)]
    count = 0
    for part in parts():
        count += len(part)
        if is_long(count):
            return parts
        arrays.append(part)
    whole = [np.concatenate(arrays)] if len(arrays) != 2 else arrays[1:]
    return lambda: whole


def quantile(parts: Callable[[], Iterable[np.ndarray]], share: float) -> float:
    """As ``np.quantile`` over all values of the parts, which are iterated several times; NaN if there are none.

    None of the values may be NaN.
    """
    parts = joined_if_short(parts)
    count = sum(map(len, parts()))
    if not is_long(count):
        (whole,) = parts()
        return float(np.quantile(whole, share)) if count else math.nan
    place = (count - 1) * share
    below, above = _neighbours(parts, count, int(place))
    beyond = place - int(place)
    # as NumPy does it, to the digit
    return above - (above - below) * (1.0 - beyond) if beyond >= 0.5 else below + (above - below) * beyond


def median(parts: Callable[[], Iterable[np.ndarray]]) -> float:
    """As ``np.median`` over all values of the parts together; see ``quantile``."""
    parts = joined_if_short(parts)
    count = sum(map(len, parts()))
    if not is_long(count):
        (whole,) = parts()
        return float(np.median(whole)) if count else math.nan
    below, above = _neighbours(parts, count, (count - 1) // 2)
    return below if count % 2 else 0.5 * (below + above)


def _neighbours(parts: Callable[[], Iterable[np.ndarray]], count: int, rank: int) -> tuple[float, float]:
    """The values at a rank (counted from 0) and the next one among so many; the same twice if there is no next.

    A random draw gives two values between which they lie; only the few values in between are sorted.
    """
    drawn = np.sort(_draw(parts()))
    place, margin = round(rank / count * len(drawn)), _SURE * math.isqrt(len(drawn))
    while True:
        low = drawn[place - margin] if place >= margin else -np.inf
        high = drawn[place + margin] if place + margin < len(drawn) else np.inf
        below, lows, highs, between = 0, 0, 0, [np.zeros(0)]
        for part in parts():
            below += np.count_nonzero(part < low)
            lows += np.count_nonzero(part == low)
            highs += np.count_nonzero(part == high) if high > low else 0  # equal values are already counted
            between.append(part[(part > low) & (part < high)])
        inside = np.sort(np.concatenate(between))
        found = [r - below for r in (rank, min(rank + 1, count - 1))]
        if (found[0] >= 0 and found[1] < lows + len(inside) + highs) or margin > len(drawn):
            break
        margin *= _WIDER

    def value(place: int) -> float:
        if place < lows:
            return float(low)
        return float(inside[place - lows] if place < lows + len(inside) else high)

    return value(found[0]), value(found[1])


def _draw(parts: Iterable[np.ndarray]) -> np.ndarray:
    """One value from each block of the parts, at a random place: with a fixed stride, periodic signals would alias.

    The same parts give the same draw.
    """
    chance = np.random.default_rng(0)
    drawn = []
    for part in parts:
        starts = np.arange(0, len(part), _DRAWN)
        drawn.append(part[np.minimum(starts + chance.integers(0, _DRAWN, len(starts)), len(part) - 1)])
    return np.concatenate(drawn)


def _write(file: BinaryIO, values: np.ndarray) -> None:
    data = values.tobytes()
    try:
        written = 0
        while written < len(data):
            written += os.write(file.fileno(), memoryview(data)[written:])
    except OSError as error:
        raise _cannot_store(error) from None


@functools.cache
def _allow_open_files() -> None:
    """Raise this process's limit of open files to the maximum: each column on disk is one, a recording has some 20."""
    _, highest = resource.getrlimit(resource.RLIMIT_NOFILE)
    with contextlib.suppress(OSError, ValueError):  # then the old limit remains
        resource.setrlimit(resource.RLIMIT_NOFILE, (highest, highest))


def _cannot_store(error: OSError) -> InputError:
    """The error for the user if a column cannot be written to disk, or mapped."""
    if error.errno in (errno.EMFILE, errno.ENFILE):
        limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        return InputError(
            f"long recordings need some 20 open files each, and this process may have {limit} ({error.strerror}); "
            "give fewer recordings at a time, or raise the limit (ulimit -n)"
        )
    # not tempfile.gettempdir(): it raises if no folder is writable, which is often the case here
    folder = tempfile.tempdir or os.environ.get("TMPDIR", "/tmp")
    return InputError(
        f"{folder}: cannot store a long recording there ({error.strerror}); free some space, or name another folder "
        "in TMPDIR"
    )
