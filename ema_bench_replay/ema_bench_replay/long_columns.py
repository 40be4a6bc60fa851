"""Columns of long recordings: they lie on disk and are gone through piece by piece, so that memory has a bound.

A recording of up to ``WHOLE`` samples lies in memory, and what is worked out of its columns is worked out at once. The
columns of a longer one are files without names, in the folder for temporary files (``TMPDIR``), that are mapped into
memory. They are arrays as any others; but what was looked at of them counts as the process's memory until
``release_pages``. Whatever goes through them with ``pieces`` needs room for one piece. Sums over several pieces may
differ in their last digits from sums over the whole.
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
"""Samples of the longest recording that lies in memory: an hour at 500 Hz, which ``compare`` takes 0.6 GiB for."""
PIECE = 1 << 18
"""Samples of a longer one that are worked on at a time."""

_DRAWN = 64  # samples of which one is drawn by chance, to see about where a quantile lies
_SURE = 4  # roots of the number drawn, within which it lies by its rank among them: eight standard deviations or more
_WIDER = 4  # times, where it does not

_mappings: weakref.WeakSet[mmap.mmap] = weakref.WeakSet()
_lock = threading.Lock()


def is_long(count: int) -> bool:
    """Whether so many samples are more than are worked on at once."""
    return count > WHOLE


def pieces(count: int, multiple: int = 1) -> Iterator[slice]:
    """What goes through so many samples: one slice for all that are no more than ``WHOLE``, else one a piece.

    Each piece but the last is a ``multiple`` of so many samples; the last is no shorter than half of the others.
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
    """Some of the pieces of so many samples, evenly over these, that are about ``WHOLE`` together."""
    every = list(pieces(count))
    chosen = np.linspace(0, len(every) - 1, max(1, min(WHOLE // PIECE, len(every))))
    return [every[k] for k in chosen.round().astype(int)]


def release_pages() -> None:
    """Give back the memory of what was looked at in columns on disk; they can be read as before."""
    with _lock:
        mappings = list(_mappings)
    for mapping in mappings:
        mapping.madvise(mmap.MADV_DONTNEED)


class Column:
    """A column that grows at its end: in memory up to ``WHOLE`` values, on disk beyond."""

    def __init__(self, kind: np.dtype | type) -> None:
        self.size = 0
        self._kind = np.dtype(kind)
        self._values = np.empty(0, self._kind)
        self._file: BinaryIO | None = None

    def add(self, values: np.ndarray) -> None:
        """Append values (m,). Raises InputError where the disk has no room for them."""
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
        """Append so many times one value."""
        for rows in pieces(count):
            self.add(np.full(rows.stop - rows.start, value, self._kind))

    def finish(self) -> np.ndarray:
        """The column (n,); read-only where it lies on disk. Nothing is added after that."""
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
    """What a function makes of columns (n,), piece by piece: as many values as it gives for each piece, in a row.

    With a ``margin`` it sees so many samples on either side of each piece, and gives a value a sample.
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
    """The pieces of a column (n,), each after the last value of the one before."""
    for rows in pieces(len(column)):
        yield column[max(rows.start - 1, 0) : rows.stop]


def times(column: np.ndarray, factor: float) -> np.ndarray:
    """A column (n,) times a number."""
    return by_pieces(lambda part: part * factor, column)


def divided(column: np.ndarray, divisor: float) -> np.ndarray:
    """A column (n,) divided by a number."""
    return by_pieces(lambda part: part / divisor, column)


def shifted(column: np.ndarray, way: float) -> np.ndarray:
    """A column (n,) and a number more."""
    return by_pieces(lambda part: part + way, column)


def slopes(values: np.ndarray, over: np.ndarray) -> np.ndarray:
    """As ``np.gradient`` of values (n,) over what rises strictly (n,)."""
    return by_pieces(np.gradient, values, over, margin=1)


def differences(column: np.ndarray) -> np.ndarray:
    """As ``np.diff`` of a column (n,)."""
    return by_pieces(np.subtract, column[1:], column[:-1])


def mean_of(column: np.ndarray) -> np.floating:
    """The mean of a column (n,); NaN where that is empty."""
    total: np.floating = sum((np.sum(column[rows]) for rows in pieces(len(column))), np.float64(0.0))
    return total / len(column) if len(column) else np.float64(math.nan)


def extremes(column: np.ndarray) -> tuple[float, float]:
    """The least and the greatest value of a column (n,) that is no NaN; NaN where there is none."""
    least = greatest = np.nan
    for rows in pieces(len(column)) if len(column) else ():
        least = np.fmin(least, np.fmin.reduce(column[rows]))
        greatest = np.fmax(greatest, np.fmax.reduce(column[rows]))
    return float(least), float(greatest)


def places_where(condition: Callable[..., np.ndarray], *columns: np.ndarray) -> np.ndarray:
    """The places (m,) in columns (n,) of what a condition holds of."""
    of_pieces = pieces(len(columns[0]))
    return np.concatenate([r.start + np.flatnonzero(condition(*(column[r] for column in columns))) for r in of_pieces])


def steps_where(condition: Callable[[np.ndarray], np.ndarray], column: np.ndarray) -> np.ndarray:
    """The places (m,) of the steps between neighbours in a column (n,) of which a condition holds."""
    return places_where(lambda later, earlier: condition(later - earlier), column[1:], column[:-1])


def less_rows(column: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """The column (n,) less some rows, which rise."""
    if not is_long(len(column)):
        return np.delete(column, rows)
    made = Column(column.dtype)
    for piece in pieces(len(column)):
        made.add(np.delete(column[piece], rows[slice(*np.searchsorted(rows, (piece.start, piece.stop)))] - piece.start))
    return made.finish()


def joined_if_short(parts: Callable[[], Iterable[np.ndarray]]) -> Callable[[], Iterable[np.ndarray]]:
    """The parts, which are asked for again and again: as a single one where they are not long together."""
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
    """As ``np.quantile`` over all values of the parts together, which are asked for again and again; NaN without any.

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
    """The values of a rank (counted from 0) and of the next among so many; the same twice where there is no next.

    A draw tells between which two values they lie; what lies between these is few, and is sorted.
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
            highs += np.count_nonzero(part == high) if high > low else 0  # equal ones are counted already
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
    """One value out of each block of the parts, at a place by chance: at every so manyth, what is periodic repeats.

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
    """Let this process have as many open files as it may: each column on disk is one, and a recording has some 20."""
    _, highest = resource.getrlimit(resource.RLIMIT_NOFILE)
    with contextlib.suppress(OSError, ValueError):  # then the old limit holds
        resource.setrlimit(resource.RLIMIT_NOFILE, (highest, highest))


def _cannot_store(error: OSError) -> InputError:
    """What to tell the user where a column cannot be written to disk, or mapped."""
    if error.errno in (errno.EMFILE, errno.ENFILE):
        limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        return InputError(
            f"long recordings need some 20 open files each, and this process may have {limit} ({error.strerror}); "
            "give fewer recordings at a time, or raise the limit (ulimit -n)"
        )
    # not tempfile.gettempdir(), which raises where it finds no folder that it can write to: often the case here
    folder = tempfile.tempdir or os.environ.get("TMPDIR", "/tmp")
    return InputError(
        f"{folder}: cannot store a long recording there ({error.strerror}); free some space, or name another folder "
        "in TMPDIR"
    )
