"""A text trace as its header and blocks of rows, in which one mark that the header shows separates the cells."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import BinaryIO

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.blank_columns import rows_with_tabs, with_tabs
from ema_bench_replay.traces.header_lines import HeaderLines, NoHeader, header_lines
from ema_bench_replay.traces.keyed_trace import refuse_keyed_trace
from ema_bench_replay.traces.named_numbers import named_numbers, without_names
from ema_bench_replay.traces.quoted_cells import with_marks_hidden
from ema_bench_replay.traces.row_ends import rows_without_ends, without_row_ends
from ema_bench_replay.traces.text_blocks import text_blocks


@dataclass(frozen=True)
class TraceText:
    """A trace's header, and the blocks of whole lines below it, each with whether it is the last."""

    header: HeaderLines
    blocks: Iterator[tuple[bytes, bool]]
    delimiter: str | None  # None: to be told by the header
    names_numbers: bool = False  # whether each row of the file names its numbers


def trace_text(path: Path, file: BinaryIO, delimiter: str | None) -> TraceText:
    """The text of a trace: tabs stand for separating blanks, unless the ``delimiter`` is known, and no row has an end.

    Raises InputError without a header, and NotText.
    """
    blocks = ((with_marks_hidden(block), last) for block, last in text_blocks(file))
    first, is_last = next(blocks)
    refuse_keyed_trace(path, first)
    if (named := named_numbers(first)) is not None:
        first, names = named
        delimiter = "\t"
        blocks = ((without_names(block, names), last) for block, last in blocks)
    unended = first if delimiter == ";" else without_row_ends(first)
    if unended is not first:
        first, blocks = unended, ((rows_without_ends(block), last) for block, last in blocks)
    tabbed = with_tabs(first) if delimiter is None else first
    if tabbed is not first:
        first, blocks = tabbed, ((rows_with_tabs(block), last) for block, last in blocks)
    header = _header(path, first)
    if named is not None:  # its header is no line of the file
        header = replace(header, line=header.line - 1)
    return TraceText(header, chain([(first[header.end :], is_last)], blocks), delimiter, named is not None)


def _header(path: Path, block: bytes) -> HeaderLines:
    """The header of a text that begins with this block. Raises InputError if it has none."""
    try:
        found = header_lines(block)
    except NoHeader as missing:
        names = missing.delimiter.join(("time [s]", "motor position [rad]", "motor speed [rad/s]", "current [A]"))
        lacked = f"{missing.cells} cells, and no line above them names as many columns"
        if missing.cells == 1:
            lacked = "the first line is numbers: no names of columns"
        raise InputError(
            f"{path}: line {missing.line}: {lacked}; put one there with a name and a unit for each, as in '{names}'"
        ) from None
    if found is None:
        raise InputError(f"{path}: {'has no header line' if block else 'is empty'}; export the trace again")
    return found
