"""Read the rows of a text trace as numbers: detect delimiter and number format, and check every cell."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ema_bench_replay.errors import InputError, MissingNumberError
from ema_bench_replay.traces.incomplete_ends import MOST, empty_ends
from ema_bench_replay.traces.missing_numbers import holds_nothing, is_missing
from ema_bench_replay.traces.number_format import ENGLISH, FORMATS, GERMAN, NumberFormat, detect
from ema_bench_replay.traces.quoted_cells import with_marks_shown
from ema_bench_replay.traces.table_ends import TableEnds
from ema_bench_replay.traces.time_of_day import is_time_of_day, seconds

_ROWS_FOR_DECIMALS = 50


@dataclass(frozen=True)
class Style:
    """How the rows of a text trace are written."""

    delimiter: str = ";"
    trailing: bool = True  # a delimiter ends each row
    newline: str = "\r\n"
    decimal: str = ","
    thousands: str = "."  # empty if thousands are not grouped


class RowReader:
    """Reads the rows of one file; the format of the first rows holds for all."""

    def __init__(
        self,
        path: Path,
        header: str,
        header_line: int,
        body: bytes,
        delimiter: str | None,
        number_format: str | None,
        needed: Callable[[list[str]], Collection[int]],
        at_ends: Callable[[list[str]], Collection[int]] | None = None,
    ) -> None:
        self.path = path
        self.line = self.first_line = header_line + 1  # of the next row
        self.waiting = b""  # blank lines and comments that end the rows read so far
        self.warnings: list[str] = []
        self.names_numbers = False  # whether each row of the file names its numbers
        self.notes = 0  # rows so far that hold a cell below the header's last name, which is empty
        self.times_of_day: set[int] = set()  # columns that hold such
        self.empty: list[int] = []  # rows of the file, counted from 0, that hold nothing and are left out
        self.written_delimiter = delimiter or next((mark for mark in (";", "\t", ",") if mark in header), ";")
        cells = [with_marks_shown(cell.strip().strip('"').strip()) for cell in header.split(self.written_delimiter)]
        self.trailing = len(cells) > 1 and not cells[-1]
        self.header = cells[:-1] if self.trailing else cells
        self.needed = sorted(needed(self.header))
        signals = self.needed if at_ends is None else sorted(at_ends(self.header))
        name, first = path.name, self.first_line
        self.ends = TableEnds(name, self.header, first, self.needed, signals, self._no_number, self.warnings)
        # A comma inside quotation marks is part of a number; those between cells become semicolons.
        self.quoted_commas = self.written_delimiter == "," and b'"' in body
        self.delimiter = ";" if self.quoted_commas else self.written_delimiter
        sample = self._tidy(body)
        self.format = self._format(sample, number_format)
        self.grouped = self.format.thousands.encode() in sample and self.delimiter != self.format.thousands
        self.decimals = self._decimals(sample)

    def style(self, newline: str) -> Style:
        """How the rows read so far are written; ``newline`` ends them."""
        thousands = self.format.thousands if self.grouped else ""
        return Style(self.written_delimiter, self.trailing, newline, self.format.decimal, thousands)

    def read(self, block: bytes, is_last: bool) -> np.ndarray:
        """The rows of a block, float64 (rows, columns)."""
        text = self.waiting + self._tidy(block)
        rows_end = _end_of_rows(text)
        text, self.waiting = text[:rows_end], text[rows_end:]  # at the end of the file, what waits is no row
        if is_last and text and not text.endswith(b"\n"):
            text = self._without_torn_row(text)
        rows = self._fast(text, len(self.header), self.trailing)
        if rows is None:
            text = self._without_notes(text)
            rows = self._only_needed(text)
        if rows is None:
            rows = self._careful(text, is_last)
        self.line += text.count(b"\n")
        self.ends.saw(rows)
        return rows

    def texts(self, block: bytes) -> Iterator[list[str]]:
        """The cells of each row of a block of whole lines, as they are written but for marks and blanks around them."""
        text = self._tidy(block)
        return (self._cells(line.decode(errors="replace")) for line in text[: _end_of_rows(text)].split(b"\n"))

    def _tidy(self, block: bytes) -> bytes:
        """The block without quotation marks, and without blanks around its cells."""
        if b'"' in block:
            if self.quoted_commas:
                block = re.sub(rb'"([^"\n]*)"|,', lambda found: b";" if found[1] is None else found[1], block)
            block = block.translate(None, b'"')
        if b" " in block or (b"\t" in block and self.delimiter != "\t"):
            blank = rb"[ \t]*" if self.delimiter != "\t" else b" *"
            block = re.sub(blank + rb"([\n" + self.delimiter.encode() + rb"])" + blank, rb"\1", block).lstrip(b" ")
        return block

    def _format(self, sample: bytes, number_format: str | None) -> NumberFormat:
        if number_format:
            return FORMATS[number_format]
        form, assumed = detect(sample, self.delimiter, ENGLISH if self.written_delimiter == "," else GERMAN)
        if assumed:
            self.warnings.append(f"{self.path.name}: {assumed}; set number_format in the import map if that is wrong")
        return form

    def _decimals(self, sample: bytes) -> list[int]:
        """The maximum number of decimals of each column in the first rows."""
        lines = sample[: 1 << 16].decode("latin-1").split("\n")[:_ROWS_FOR_DECIMALS]
        most = [0] * len(self.header)
        for line in lines[:-1]:
            for place, cell in enumerate(line.split(self.delimiter)[: len(most)]):
                most[place] = max(most[place], len(cell.partition(self.format.decimal)[2]))
        return most

    def _without_torn_row(self, text: bytes) -> bytes:
        """A text whose last row lacks a line end: with one added if the row is complete, otherwise without the row."""
        end = text.rfind(b"\n") + 1
        cells = text[end:].decode("latin-1").split(self.delimiter)
        whole = len(cells) == len(self.header) + self.trailing
        if whole and not self.trailing:
            whole = len(cells[-1].partition(self.format.decimal)[2]) == self.decimals[-1]
        if whole:
            return text + b"\n"
        self._report_torn(self.line + text.count(b"\n"))
        return text[:end]

    def report_empty(self) -> None:
        """Warn of the rows that hold nothing."""
        first, count = self.first_line + self.empty[0], len(self.empty)
        which = f"line {first} holds" if count == 1 else f"{count} rows (the first in line {first}) hold"
        self.warnings.append(f"{self.path.name}: {which} no number in any column: left out")

    def _report_torn(self, line: int) -> None:
        self.warnings.append(
            f"{self.path.name}: line {line}: the last row is cut, so only the rows before it can be used"
        )

    def _without_notes(self, text: bytes) -> bytes:
        """The rows without what stands below a last empty name, as notes beside a table, unless most rows hold it."""
        if not self.trailing:
            return text
        mark, width = self.delimiter.encode(), len(self.header) + 1
        lines = [line.split(mark) for line in text.split(b"\n")]
        noted = [cells for cells in lines if len(cells) == width and cells[-1]]
        self.notes += len(noted)
        if 2 * self.notes > self.line - self.first_line + text.count(b"\n"):
            return text
        for cells in noted:
            cells[-1] = b""
        return b"\n".join(mark.join(cells) for cells in lines)

    def _only_needed(self, text: bytes) -> np.ndarray | None:
        """The rows, with NaN in unneeded columns, if the others contain nothing unusual; otherwise None."""
        if not 0 < len(self.needed) < len(self.header):
            return None
        mark, width = self.delimiter.encode(), len(self.header) + self.trailing
        lines = [line.split(mark) for line in text.split(b"\n")[:-1]]
        if any(len(cells) != width or (self.trailing and cells[-1]) for cells in lines):
            return None
        picked = b"".join(mark.join([cells[place] for place in self.needed]) + b"\n" for cells in lines)
        values = self._fast(picked, len(self.needed), trailing=False)
        if values is None:
            return None
        rows = np.full((len(lines), len(self.header)), np.nan)
        rows[:, self.needed] = values
        return rows

    def _fast(self, text: bytes, columns: int, trailing: bool) -> np.ndarray | None:
        """The rows if they contain nothing unusual, otherwise None. The result equals that of `_careful`."""
        delimiter, form = self.delimiter.encode(), self.format
        if not text or text.translate(None, b"0123456789+-.,eE\n" + delimiter):
            return None
        buffer = np.frombuffer(text, dtype=np.uint8)
        is_end = buffer == ord("\n")
        ends = np.flatnonzero((buffer == delimiter[0]) | is_end)
        count = int(np.count_nonzero(is_end))
        width = columns + trailing
        if ends.size != count * width or not is_end[ends[width - 1 :: width]].all():
            return None
        lengths = np.diff(ends, prepend=-1).reshape(count, width) - 1
        if (lengths[:, :columns] == 0).any() or (trailing and lengths[:, -1].any()):
            return None
        if form.thousands == self.delimiter:
            dropped = b""
        elif form.groups_are_whole(text):
            dropped = form.thousands.encode()
        else:
            return None
        if dropped and dropped in text and b"e" in text.lower():
            return None  # a mark inside an exponent (1E1.000) is not a thousands mark
        plain = text.translate(bytes.maketrans(form.decimal.encode() + delimiter, b". "), dropped)
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)  # NumPy 1 warns so if it cannot parse further
            try:
                values = np.fromstring(plain, sep=" ")
            except (ValueError, DeprecationWarning):
                return None
        return values.reshape(count, -1) if values.size == count * columns else None

    def _careful(self, text: bytes, is_last: bool) -> np.ndarray:
        """The rows, cell by cell; InputError names the first wrong one.

        The file's first and last few rows are left out if they lack numbers that all others hold, as a logger writes
        that is switched on before its drive answers, or off meanwhile; and more of them if cells of them are empty.
        """
        whole = self._whole_rows(text, is_last)
        rows = np.empty((len(whole), len(self.header)))
        split = [self._cells(line) for _, line in whole]
        is_first = self.line == self.first_line
        first, last = empty_ends(split, self.line - self.first_line + len(whole))
        empty_first, empty_last = first if is_first else {}, last if is_last else {}
        begins = is_first and len(whole) > 2 * MOST
        at_begin: dict[int, dict[int, str]] = {}  # cells of the first rows that are no numbers, by row and column
        at_end: dict[int, dict[int, str]] = {}  # those of the last rows
        for number, ((at, _), cells) in enumerate(zip(whole, split, strict=True)):
            if len(cells) != len(self.header):
                self._refuse_unnamed([line for _, line in whole])
                raise self._other_cells(at, len(cells))
            may_end = is_last and len(whole) - number <= MOST and at > self.first_line
            for column, cell in enumerate(cells):
                try:
                    rows[number, column] = self.format.value(cell)
                except ValueError:
                    if is_time_of_day(cell):
                        rows[number, column] = seconds(cell)
                        self.times_of_day.add(column)
                        continue
                    rows[number, column] = np.nan
                    if number < empty_first.get(column, 0) or len(whole) - number <= empty_last.get(column, 0):
                        continue
                    if begins and number < MOST and not _is_number(cell):
                        at_begin.setdefault(number, {})[column] = cell
                    elif may_end and not _is_number(cell):
                        at_end.setdefault(number, {})[column] = cell
                    elif column in self.needed:
                        self.ends.refuse_needed(at_begin, [line for line, _ in whole])
                        raise self._no_number(at, column, cell) from None
        lines = [at for at, _ in whole]
        return self.ends.without(rows, (empty_first, empty_last), split, (at_begin, at_end), lines)

    def _whole_rows(self, text: bytes, is_last: bool) -> list[tuple[int, str]]:
        """The lines of a text with their numbers, without those that hold nothing and without a cut last row."""
        numbered = [(self.line + k, line) for k, line in enumerate(text.decode("latin-1").split("\n")[:-1])]
        whole = [(at, line) for at, line in numbered if not holds_nothing(line.split(self.delimiter))]
        held = {at for at, _ in whole}
        self.empty += [at - self.first_line for at, _ in numbered if at not in held]
        if is_last and whole and whole[-1] == numbered[-1] and len(self._cells(whole[-1][1])) < len(self.header):
            self._report_torn(whole.pop()[0])
        return whole

    def _refuse_unnamed(self, lines: list[str]) -> None:
        """Raise InputError if all rows have as many cells more than the header has names."""
        if self.line > self.first_line:  # those before had as many as the header
            return
        widths = {len(line.removesuffix(self.delimiter).split(self.delimiter)) for line in lines}
        more = widths.pop() - len(self.header)
        if widths or more <= 0:
            return
        last = "the last column" if more == 1 else f"the last {more} columns"
        raise InputError(
            f"{self.path}: line {self.first_line - 1}: the header names {len(self.header)} columns, and each row has "
            f"{len(self.header) + more} cells; name {last} too"
        )

    def _other_cells(self, line: int, count: int) -> InputError:
        """That a row has another ``count`` of cells than the header has names."""
        if self.names_numbers:
            wrong = f"does not name {', '.join(self.header)}, in this order and each with a number; correct"
            return InputError(f"{self.path}: line {line}: {wrong} or remove the row")
        wrong = f"has {count} cell{'s' * (count != 1)} where the header has {len(self.header)}; remove or complete"
        return InputError(f"{self.path}: line {line}: {wrong} the row")

    def _cells(self, line: str) -> list[str]:
        """The cells of a row, without the empty one that a delimiter at its end makes."""
        cells = line.split(self.delimiter)
        if not cells[-1] and (self.trailing or len(cells) == len(self.header) + 1):
            cells.pop()
        return cells

    def _no_number(self, line: int, column: int, cell: str) -> InputError:
        wrong = f"{cell!r} is no number in {self.format.example} format" if cell else "the cell is empty"
        if cell.strip().lower() == "nan":
            wrong = "holds no value (NaN)"
        kind = MissingNumberError if not cell or is_missing(cell) else InputError
        return kind(
            f"{self.path}: line {line}: column {self.header[column]!r}: {wrong}; correct it, remove the "
            "row, or leave the column out of the import map"
        )


def _is_number(cell: str) -> bool:
    """Whether a cell is a number in any format."""
    return any(form.pattern.fullmatch(cell) for form in FORMATS.values())


def _end_of_rows(text: bytes) -> int:
    """The byte at which the blank lines and comments (#, %) at the end of a text begin."""
    end = len(text)
    while end:
        begin = text.rfind(b"\n", 0, end - 1) + 1
        line = text[begin:end].strip()
        if line and not line.startswith((b"#", b"%")):
            break
        end = begin
    return end
