"""Find the header of a text trace: programs write information above it, and often a row of units below it.

The header is the line above the first row of numbers. Comments, blank lines and quoted texts above it are skipped, and
so is what stands between it and the rows, unless it begins with a number, as a row that is cut does. A logger that
starts before its drive answers writes NaN, or nothing, beside the time of its first rows: they are rows all the same.
Where short names follow a row of units, the names above the units are the header, if each column has its own there.
Information above the header may hold numbers among words: lines of numbers above a line of names are no rows if none of
them holds numbers where the rows below that line do. If
nothing else names the columns, a comment directly above the rows with the same number of cells does, as written by
numpy; if it holds units, and the comment above it as many names, these do.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from ema_bench_replay.traces.header_words import is_unit
from ema_bench_replay.traces.missing_numbers import holds_nothing, is_missing
from ema_bench_replay.traces.paired_columns import names_of_pairs
from ema_bench_replay.traces.text_blocks import MOST_LINES
from ema_bench_replay.traces.time_of_day import is_time_of_day

_DELIMITERS = (";", "\t", ",")
_NUMBER = re.compile(r"[-+]?[\d.,]*\d[\d.,]*(?:[eE][-+]?\d+)?")
_COMMENT = re.compile(r'[#%]|sep=|("[^"]*")?\Z', re.IGNORECASE)
_UNIT_MARK = re.compile(r"[\[(].*[\])]|[-+\w.*·^⁻¹²]*[°%/µμΩ][-+\w./*·^⁻¹² ]*")
_TIMES = {"s", "sec", "ms", "us", "ns", "min"}
_OTHER_UNITS = {"min", "w", "kw", "hz", "raw", "bit", "bits"}
"""Units in lower case of what no signal measures; others that are not known have a character that names do not have."""


@dataclass(frozen=True)
class HeaderLines:
    """The header's text, the number (counted from 1) of the last line above the rows, and the byte at which it ends."""

    text: str
    line: int
    end: int  # the first byte of the rows
    pairs: bool = False  # whether each signal is a pair of columns, of its time and its values


class NoHeader(ValueError):
    """Rows of so many cells begin in a line (counted from 1), but nothing above them names as many columns."""

    def __init__(self, line: int, cells: int, delimiter: str) -> None:
        super().__init__(line)
        self.line, self.cells, self.delimiter = line, cells, delimiter


def header_lines(block: bytes) -> HeaderLines | None:
    """The header of a text that begins with ``block``; None if it has none.

    Without rows among the first lines, it is the first line that is not a comment. Raises NoHeader if nothing above the
    numbers can name their columns.
    """
    lines: list[tuple[str, int]] = []
    end = 0
    while end < len(block) and len(lines) < MOST_LINES:
        after = block.find(b"\n", end) + 1 or len(block)
        lines.append((_decoded(block[end:after]), after))
        end = after
    plain = next((k for k, (text, _) in enumerate(lines) if not _is_comment(text)), None)
    if plain is None:
        return None
    lines_of_names = _names_below_information(lines, plain)
    if lines_of_names is not None:
        plain = lines_of_names
    if _is_row(lines[plain][0]) and all(_names_nothing(text) for text, _ in lines[plain + 1 : plain + 2] if text):
        return _header_in_comment(lines, plain)
    rows = _first_row(lines, plain)
    if rows == plain:
        return _header_in_comment(lines, plain)
    header, of_units = (plain, None) if rows is None else _above(lines, plain, rows)
    text = lines[header][0]
    if not re.search(r"[^\W\d_]", text) and _NUMBER.match(text):
        raise NoHeader(header + 1, 1, _delimiter(text))
    if rows is not None and of_units is not None:
        mark = _delimiter(text)
        units = _cells(lines[of_units][0], mark)
        text = mark.join(_with_units(_with_time(_cells(text, mark), units), units))
        text += mark if text.endswith(mark) else ""  # an empty name at the end is one
    elif rows is not None and header == rows - 1:
        mark = _delimiter(lines[rows][0])
        cells, width = _cells(text, mark), len(lines[rows][0].split(mark))
        if len(cells) == width + 1 > 2:
            text = mark.join(cells[:width])
    pairs = names_of_pairs(lines[header - 1][0], text, _delimiter(text)) if header else None
    last = header if rows is None or (of_units is None and _torn_row(lines, header, rows)) else rows - 1
    return HeaderLines(pairs or text, last + 1, lines[last][1], pairs is not None)


def _first_row(lines: list[tuple[str, int]], plain: int) -> int | None:
    """Index of the first row from ``plain`` on; None if no line below that holds numbers.

    It is the first line with numbers, or the first of those directly above it that are as wide and hold values only.
    """
    rows = next((k for k in range(plain + 1, len(lines)) if _is_row(lines[k][0])), None)
    if rows is None:
        return None
    mark = _delimiter(lines[rows][0])
    width = lines[rows][0].count(mark)
    while rows > plain and lines[rows - 1][0].count(mark) == width and _may_be_empty_row(lines[rows - 1][0]):
        rows -= 1
    return rows


def _names_below_information(lines: list[tuple[str, int]], plain: int) -> int | None:
    """Index of a line of names below lines that hold numbers but are no rows; None if the first of these is a row.

    All of them have words, or no cell, where the rows below the names hold numbers.
    """
    first = next((k for k in range(plain, len(lines)) if _is_row(lines[k][0])), None)
    if first is None:
        return None
    for k in range(first + 1, len(lines) - 1):
        below = k + 1 if _is_row(lines[k + 1][0]) else k + 2
        if not _is_line_of_names(lines[k][0]) or below >= len(lines) or not _is_row(lines[below][0]):
            continue
        told = [text for text, _ in lines[first:k] if _is_row(text)]
        return None if any(_is_row_like(text, lines[below][0]) for text in told) else k
    return None


def _is_line_of_names(line: str) -> bool:
    """Whether a line holds several names and no value; cells at its end may be empty."""
    cells = [_plain(cell) for cell in line.split(_delimiter(line))]
    while cells and not cells[-1]:
        cells.pop()
    return len(cells) > 1 and not _is_comment(line) and all(map(_is_name, cells))


def _is_name(cell: str) -> bool:
    known = _NUMBER.fullmatch(cell) or is_missing(cell) or is_time_of_day(cell)
    return not known and re.search(r"[^\W\d_]", cell) is not None


def _is_row_like(line: str, row: str) -> bool:
    """Whether a line holds a number, or a missing one, wherever a row holds a number."""
    mark = _delimiter(row)
    cells, others = ([_plain(cell) for cell in text.split(mark)] for text in (line, row))
    if len(cells) != len(others):
        return False
    pairs = zip(cells, others, strict=True)
    return all(not cell or _NUMBER.fullmatch(cell) or is_missing(cell) for cell, of in pairs if _NUMBER.fullmatch(of))


def _torn_row(lines: list[tuple[str, int]], header: int, rows: int) -> bool:
    """Whether a line between the header and the first whole row begins with a number, so that it may be a row."""
    between = (text for text, _ in lines[header + 1 : rows])
    return any(_NUMBER.fullmatch(text.split(_delimiter(text))[0].strip(' "')) for text in between)


def _header_in_comment(lines: list[tuple[str, int]], rows: int) -> HeaderLines:
    """The header in the comment directly above rows that begin a text. Raises NoHeader if there is none."""
    mark = _delimiter(lines[rows][0])
    if rows:
        text = _uncommented(lines[rows - 1][0])
        cells, before = _cells(text, mark), _cells(_uncommented(lines[rows - 2][0]) if rows > 1 else "", mark)
        if len(before) == len(cells) and _are_units(cells) and _are_names(_with_time(before, cells)):
            cells = _with_units(_with_time(before, cells), cells)
            text = mark.join(cells)
        if len(cells) == _width(lines[rows][0], mark) and _are_names(cells):
            return HeaderLines(text, rows, lines[rows - 1][1])
    raise NoHeader(rows + 1, _width(lines[rows][0], mark), mark)


def _above(lines: list[tuple[str, int]], plain: int, rows: int) -> tuple[int, int | None]:
    """Index among the lines of the header and of the line of units, if there is one.

    ``rows`` is where the rows begin, ``plain`` the first non-comment line.

    Raises NoHeader if no line there has as many cells as the rows, unless a line with several is directly above them.
    """
    mark = _delimiter(lines[rows][0])
    whole = len(lines[rows][0].split(mark))
    widths = whole, _width(lines[rows][0], mark)  # a delimiter at the end of a row may end it, or begin an empty cell

    def wide(k: int, *cells: int) -> bool:
        text = lines[k][0]
        return k >= plain and not _is_comment(text) and max(cells) > 1 and _width(text, mark) in cells

    if not wide(rows - 1, *widths):
        if wide(rows - 1, whole + 1):  # a column of comments that is empty in all rows
            return rows - 1, None
        if plain == rows - 1 and _width(lines[plain][0], mark) > 1:  # a name too many or too few
            return plain, None
        header = next((k for k in range(rows - 2, plain - 1, -1) if wide(k, *widths)), None)
        if header is None:
            raise NoHeader(rows + 1, widths[1], mark)
        return header, None
    last, before, first = (_cells(lines[k][0], mark) if k >= 0 else [] for k in (rows - 1, rows - 2, rows - 3))
    if not wide(rows - 2, len(last)):
        return rows - 1, None
    if _are_units(last) or (_are_mostly_units(last) and len({*before}) == len(before)):
        return (rows - 2, rows - 1) if _are_names(_with_time(before, last)) else (rows - 1, None)
    if not _are_units(before):
        return rows - 1, None
    own_names = wide(rows - 3, len(last)) and _are_names(_with_time(first, before)) and len({*first}) == len(first)
    return (rows - 3 if own_names else rows - 1), rows - 2


def _cells(line: str, mark: str) -> list[str]:
    return line.rstrip().removesuffix(mark).split(mark)


def _decoded(raw: bytes) -> str:
    try:
        return raw.decode("utf-8").strip(" \r\n").removeprefix("\ufeff").strip(" ")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace").strip(" \r\n")


def _is_comment(line: str) -> bool:
    """Whether a line above the header says nothing about the columns."""
    return _COMMENT.match(line.strip()) is not None


def _uncommented(line: str) -> str:
    return line.strip().lstrip("#%").strip()


def _delimiter(line: str) -> str:
    return next((mark for mark in _DELIMITERS if mark in line), ";")


def _width(line: str, mark: str) -> int:
    """Number of cells in a line; a trailing delimiter does not begin a cell."""
    return len(_cells(line, mark))


def _is_row(line: str) -> bool:
    """Whether a line holds numbers: its first cell is a number or a time of day, and some other cell is a number."""
    cells = [_plain(cell) for cell in line.split(_delimiter(line))]
    numbers = [bool(_NUMBER.fullmatch(cell)) for cell in cells]
    return len(cells) > 1 and (numbers[0] or is_time_of_day(cells[0])) and any(numbers[1:])


def _names_nothing(line: str) -> bool:
    """Whether a line is a row, or would be one if its drive had answered: it begins with a value, and has no name."""
    cells = [_plain(cell) for cell in line.split(_delimiter(line))]
    values = [not cell or bool(_NUMBER.fullmatch(cell) or is_missing(cell)) for cell in cells]
    begins = bool(cells[0]) and (values[0] or is_time_of_day(cells[0]))
    return _is_row(line) or (len(cells) > 1 and begins and all(values[1:]))


def _may_be_empty_row(line: str) -> bool:
    """Whether a line directly above rows may be one of them: it names nothing, or has empty cells only."""
    return _names_nothing(line) or holds_nothing([_plain(cell) for cell in line.split(_delimiter(line))])


def _are_units(cells: list[str]) -> bool:
    """Whether all cells are units or empty, and at least one is not empty."""
    told = [cell for cell in map(_plain, cells) if cell not in ("", "-")]
    return bool(told) and all(
        is_unit(cell) or cell.lower() in _OTHER_UNITS or _UNIT_MARK.fullmatch(cell) for cell in told
    )


def _are_mostly_units(cells: list[str]) -> bool:
    """Whether more than half of the cells are units, and some are alike, as the names of columns are not.

    So a row of units is known although one of them is spelt in a way that nobody foresaw.
    """
    told = [cell for cell in map(_plain, cells) if cell not in ("", "-")]
    return len({*told}) < len(told) < 2 * sum(_are_units([cell]) for cell in told)


def _are_names(cells: list[str]) -> bool:
    """Whether all cells but the last one are names; empty ones at the end do not count."""
    end = len(cells)
    while end and not _plain(cells[end - 1]):
        end -= 1
    return end > 0 and all(re.search(r"[^\W\d]", cell) for cell in cells[: end - 1])


def _with_time(names: list[str], units: list[str]) -> list[str]:
    """The names; a first one that is empty above a unit of time, as recorders of drives leave it, is the time's."""
    if _plain(names[0]) or _plain_unit(units[0]).lower() not in _TIMES:
        return names
    return ["time", *names[1:]]


def _plain(cell: str) -> str:
    return cell.strip().strip('"').strip()


def _plain_unit(cell: str) -> str:
    return _plain(cell).strip(" []()")


def _with_units(names: list[str], units: list[str]) -> list[str]:
    """The names, each followed by its unit in brackets."""
    told = []
    for name, unit in zip(names, units, strict=False):
        plain, unit = _plain(name), _plain_unit(unit)
        told.append(f"{plain} [{unit}]" if plain and unit else plain)
    return told
