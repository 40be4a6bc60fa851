"""Read a text trace as a table of numbers: its header, and the rows below it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ema_bench_replay.errors import InputError, MissingNumberError
from ema_bench_replay.long_columns import Column, less_rows
from ema_bench_replay.recording_file import open_recording
from ema_bench_replay.traces.line_breaks import line_end
from ema_bench_replay.traces.merged_topics import with_topics_joined
from ema_bench_replay.traces.paired_columns import with_common_time
from ema_bench_replay.traces.text_blocks import NotText
from ema_bench_replay.traces.trace_rows import RowReader, Style
from ema_bench_replay.traces.trace_text import trace_text

#: A longer trace is refused: it would not fit into the memory of an ordinary machine.
LARGEST = 2 << 30
_BYTES_FOR_NEWLINE = 1 << 16


@dataclass(frozen=True)
class TraceTable:
    """The numbers of a trace, as in the file."""

    path: Path
    sha256: str
    header: list[str]  # names of the columns
    header_line: int  # number of its last line, counted from 1; the rows follow directly
    columns: list[np.ndarray]  # float64 (n,) each; unneeded columns may hold NaN
    decimals: list[int]  # number of decimals of each column
    style: Style
    warnings: tuple[str, ...]
    left_out: tuple[int, ...] = ()  # rows of the file, counted from 0 below the header, that are not in the columns
    in_seconds: frozenset[str] = frozenset()  # columns of times of day or dates, converted to s
    is_cut: bool = False  # whether rows at an end are left out, since they lack numbers that all others hold

    @property
    def numbers(self) -> dict[str, np.ndarray]:
        """The columns (n,) by their names; of several with one name, the first."""
        return {name: self.columns[self.header.index(name)] for name in self.header}

    def line(self, row: int) -> int:
        """Line number (counted from 1) of a row (counted from 0)."""
        for left_out in self.left_out:
            row += left_out <= row
        return self.header_line + 1 + row

    def place(self, row: int) -> str:
        """File and line of a row (counted from 0), for messages."""
        return f"{self.path}: line {self.line(row)}"

    def without(self, rows: np.ndarray) -> TraceTable:
        """The table without some of its rows (counted from 0, ascending)."""
        columns = [less_rows(column, rows) for column in self.columns]
        left_out = {*self.left_out, *(self.line(int(row)) - self.header_line - 1 for row in rows)}
        return replace(self, columns=columns, left_out=tuple(sorted(left_out)))


def all_columns(header: list[str]) -> Collection[int]:
    """The indices of all columns."""
    return range(len(header))


def read_table(
    path: Path,
    delimiter: str | None = None,
    number_format: str | None = None,
    needed: Callable[[list[str]], Collection[int]] = all_columns,
    progress: Callable[[float], None] = lambda share: None,
    at_ends: Callable[[list[str]], Collection[int]] | None = None,
) -> TraceTable:
    """Read a delimited text file: one header line and numbers below it.

    Above the header there may be comments (#, %), blank lines, quoted texts and lines with other cells than the rows;
    below it the same, or a row of units, which are appended to the names in brackets. Pairs of columns, of time and
    values, below each signal's name get one column for the time. Blank lines and comments may end the file. Columns may
    be separated by blanks, and a semicolon may end each row. Times of day and dates are converted to s. Rows that hold
    nothing in any column are left out, with one warning. An incomplete last row is dropped, with a warning, and so are
    up to three first and last rows that lack a number in which all others hold one, in one of the columns `at_ends` (by
    default the needed ones, or any if none is needed), or up to a quarter of the rows if its cells are empty there: at
    both ends together, unless any column counts (beyond 4 MB, within the first and the last block). Merged
    topics, each with rows of its own, are joined, with a warning. `delimiter` and `number_format` ("german", "english")
    are detected if they are None. `needed` returns for a header the columns that must hold numbers; others may hold
    words and empty cells. `progress` is called with the share read so far. Raises InputError.
    """
    try:
        table = _read(path, delimiter, number_format, needed, progress, at_ends)
        return table if needed(table.header) else with_topics_joined(table) or table
    except MissingNumberError as missing:
        try:
            joined = with_topics_joined(_read(path, delimiter, number_format, lambda header: (), progress))
        except InputError:  # further down than what is missing
            joined = None
        if joined is None or any(np.isnan(joined.columns[column]).any() for column in needed(joined.header)):
            raise missing from None
        return joined


def _read(
    path: Path,
    delimiter: str | None,
    number_format: str | None,
    needed: Callable[[list[str]], Collection[int]],
    progress: Callable[[float], None],
    at_ends: Callable[[list[str]], Collection[int]] | None = None,
) -> TraceTable:
    """The table as its cells stand in the file. Raises MissingNumberError if a needed one is empty, else InputError."""
    try:
        if (size := path.stat().st_size) > LARGEST:
            raise InputError(f"{path}: larger than {LARGEST >> 30} GiB; split it, or trace fewer signals")
        with open_recording(path) as file:
            sha256 = _sha256(file)
            newline = line_end(file.read(_BYTES_FOR_NEWLINE).replace(b"\0", b""))
            file.seek(0)
            text = trace_text(path, file, delimiter)
            body, is_last = next(text.blocks)
            header = text.header
            if header.text.lstrip().startswith("{"):
                raise InputError(f"{path}: line {header.line}: is JSON; write it as CSV, with a column for each name")
            rows = RowReader(path, header.text, header.line, body, text.delimiter, number_format, needed, at_ends)
            rows.names_numbers = text.names_numbers
            growing = [Column(np.float64) for _ in rows.header]
            for block, last in chain([(body, is_last)], text.blocks):
                for column, values in zip(growing, rows.read(block, last).T, strict=True):
                    column.add(values)
                progress(file.tell() / size)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the path and its permissions") from None
    except NotText:
        raise InputError(f"{path}: is no text; give the drive's trace exported as CSV") from None
    columns = [column.finish() for column in growing]
    if not columns[0].size:
        raise InputError(f"{path}: has a header and no rows below it; export the trace again")
    if rows.empty:
        rows.report_empty()
    style = rows.style(newline)
    in_seconds = frozenset(rows.header[column] for column in rows.times_of_day)
    table = TraceTable(
        path,
        sha256,
        rows.header,
        header.line,
        columns,
        rows.decimals,
        style,
        tuple(rows.warnings),
        tuple(sorted((*rows.empty, *rows.ends.first))),
        in_seconds=in_seconds,
        is_cut=bool(rows.ends.first or rows.ends.last),
    )
    return with_common_time(table) if header.pairs else table


def _sha256(file: BinaryIO) -> str:
    digest = hashlib.sha256()
    while block := file.read(1 << 20):
        digest.update(block)
    file.seek(0)
    return digest.hexdigest()
