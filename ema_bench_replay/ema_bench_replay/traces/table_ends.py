"""The two ends of a table that is read block by block: which rows are left out there, and what is said of them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.incomplete_ends import MOST, MOST_EMPTY, Cells, incomplete_rows, left_out_words


class TableEnds:
    """Leaves out rows at the ends of the table that lack numbers of the columns that count.

    These are the ``signals`` or, if there are none, all columns of the ``header``. A number that is missing in a row
    that stays, in one of the columns ``needed``, is refused with the error that ``no_number`` makes of its line, its
    column and its cell. ``warnings`` gets what is left out of the file of this ``name``.
    """

    def __init__(
        self,
        name: str,
        header: Sequence[str],
        first_line: int,
        needed: Collection[int],
        signals: Collection[int],
        no_number: Callable[[int, int, str], InputError],
        warnings: list[str],
    ) -> None:
        self.first: list[int] = []  # rows of the file, counted from 0, that are left out at its begin
        self.last = 0  # how many are left out at its end
        self._name = name
        self._header = header
        self._first_line = first_line
        self._needed = needed
        self._signals_known = bool(signals)
        self._judged = signals or range(len(header))
        self._no_number = no_number
        self._warnings = warnings
        self._known = np.ones(len(header), dtype=bool)  # columns in which all cells so far hold numbers
        self._seen = np.zeros(len(header), dtype=bool)  # columns in which any cell so far holds one

    def saw(self, rows: np.ndarray) -> None:
        """Keep in mind in which columns the rows of a block that stay hold numbers."""
        self._known &= np.isfinite(rows).all(axis=0)
        self._seen |= np.isfinite(rows).any(axis=0)

    def without(
        self,
        rows: np.ndarray,
        empty: tuple[Mapping[int, int], Mapping[int, int]],
        split: Sequence[Sequence[str]],
        cells: tuple[Cells, Cells],
        lines: Sequence[int],
    ) -> np.ndarray:
        """The rows of a block without those at the table's ends that lack numbers which all others hold.

        At the begin and the end each: ``empty`` counts by column the rows in which its cells are empty, and ``cells``
        are those that are no numbers, of the few rows there. ``split`` are all rows' cells, ``lines`` theirs. Raises
        InputError if a row that stays lacks a number in a needed column.
        """
        filled = self._filled(rows, *empty, split, lines)
        at_begin, at_end = cells
        if filled.start:
            at_begin = {}
        last = {row: held for row, held in at_end.items() if row < filled.stop}
        inside = rows[filled.start : filled.stop - len(last)]
        complete = self._complete(inside, at_begin, lines[filled.start : filled.stop], at_begin=True)
        begin = filled.start + complete.start
        self.first += [line - self._first_line for line in lines[filled.start : begin]]
        below = {row - begin: held for row, held in last.items()}
        complete = self._complete(rows[begin : filled.stop], below, lines[begin : filled.stop], at_begin=False)
        return rows[begin : begin + complete.stop]

    def _filled(
        self,
        rows: np.ndarray,
        empty_first: Mapping[int, int],
        empty_last: Mapping[int, int],
        split: Sequence[Sequence[str]],
        lines: Sequence[int],
    ) -> range:
        """The rows between those at both ends in which columns are empty that hold numbers in all others.

        ``empty_first`` and ``empty_last`` count such rows by column; ``split`` are all rows' cells, ``lines`` theirs.
        None are left out that alone hold a column's numbers. Raises InputError if a needed column stays empty there.
        """
        count = len(rows)
        between = {
            column: range(empty_first.get(column, 0), count - empty_last.get(column, 0)) for column in self._judged
        }
        full = {
            column: kept
            for column, kept in between.items()
            if self._known[column] and len(kept) < count and np.isfinite(rows[kept.start : kept.stop, column]).all()
        }
        first = max(full, key=lambda column: full[column].start, default=0)
        last = min(full, key=lambda column: full[column].stop, default=0)
        filled = range(full[first].start, full[last].stop) if full else range(count)
        outside = np.isfinite(rows[: filled.start]).any(axis=0) | np.isfinite(rows[filled.stop :]).any(axis=0)
        if (outside & ~self._seen & ~np.isfinite(rows[filled.start : filled.stop]).any(axis=0)).any():
            filled = range(count)
        left = len(self.first) + count - len(filled)  # at both ends
        if self._signals_known and left > max(MOST, MOST_EMPTY * (lines[-1] - self._first_line + 1 if lines else 0)):
            filled = range(count)
        for column in self._needed:
            at = next((row for row in filled if row not in between[column]), None)
            if at is not None:
                raise self._no_number(lines[at], column, split[at][column])
        if filled.start:
            self._report_left_out(lines[: filled.start], first, split[0][first], at_begin=True)
            self.first = [line - self._first_line for line in lines[: filled.start]]
        if filled.stop < count:
            self.last = count - filled.stop
            self._report_left_out(lines[filled.stop :], last, split[filled.stop][last], at_begin=False)
        return filled

    def _complete(self, rows: np.ndarray, cells: Cells, lines: Sequence[int], *, at_begin: bool) -> range:
        """The rows without those at an end that lack numbers; ``cells`` are theirs that are none, ``lines`` all rows'.

        Raises InputError if a row that stays lacks a number in a needed column.
        """
        whole = range(len(rows))
        most_first = (whole[:count] if at_begin else whole[-count:] for count in range(len(cells), 0, -1))
        others = ((end, rows[end.stop :] if at_begin else rows[: end.start]) for end in most_first)
        ends = ((end, self._known & np.isfinite(other).all(axis=0)) for end, other in others)
        if (found := incomplete_rows(ends, cells, self._judged)) is not None:
            end, column = found
            told = [lines[row] for row in end]
            self._report_left_out(told, column, cells[end.start][column], at_begin=at_begin)
            whole = whole[end.stop :] if at_begin else whole[: end.start]
        self.refuse_needed({row: held for row, held in cells.items() if row in whole}, lines)
        return whole

    def refuse_needed(self, cells: Cells, lines: Sequence[int]) -> None:
        """Raise InputError for the first of the ``cells`` that is in a needed column."""
        for row, held in sorted(cells.items()):
            for column, cell in held.items():
                if column in self._needed:
                    raise self._no_number(lines[row], column, cell)

    def _report_left_out(self, lines: Sequence[int], column: int, cell: str, *, at_begin: bool) -> None:
        """Warn of rows at an end that are in these ``lines``; the ``cell`` is the first one's in a column."""
        told = left_out_words(lines[0], len(lines), self._header[column], cell, at_begin=at_begin)
        self._warnings.append(f"{self._name}: {told}")
