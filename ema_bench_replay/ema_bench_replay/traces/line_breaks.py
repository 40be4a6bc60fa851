"""Line breaks of a text: which bytes end a row, and which are inside a quoted cell and end none (RFC 4180)."""

from __future__ import annotations

import re

_LONE_RETURN = re.compile(rb"(?<![\r\n])\r(?![\r\n])")
_OPENING = rb'"(?<![^,;\t\n ]")'  # the mark comes first, since the search for a literal is quick
_BROKEN_CELL = re.compile(
    _OPENING + rb'[^"\n]*+(?:""[^"\n]*+)*+\n[^"]*+(?:""[^"]*+)*+"(?=[ \t]*(?:[,;\t\n]|\Z))',
)
_OPEN_CELL = re.compile(_OPENING + rb'[^"]*+(?:""[^"]*+)*+\Z')


def has_lone_returns(begin: bytes) -> bool:
    """Whether carriage returns without a line feed end the rows of a text that begins so, as Excel for Mac writes."""
    return _LONE_RETURN.search(begin.rstrip(b"\r")) is not None or b"\n" not in begin


def line_end(begin: bytes) -> str:
    """What ends each row of a text that begins so."""
    if b"\r\n" in begin:
        return "\r\n"
    return "\r" if b"\r" in begin and has_lone_returns(begin) else "\n"


def returns_as_feeds(text: bytes) -> bytes:
    """A text in which each row ends in a line feed alone."""
    return text.replace(b"\r\n", b"\n").replace(b"\n\r", b"\n").replace(b"\r", b"\n")


def without_breaks_in_cells(text: bytes) -> bytes:
    """Lines in which each quoted cell is in one line: a break inside it is a blank.

    A quotation mark that begins no cell, as that of an inch, or that none closes, is left alone.
    """
    return _BROKEN_CELL.sub(lambda cell: cell[0].replace(b"\n", b" "), text)


def end_of_lines(text: bytes, longest: int) -> int:
    """The byte behind the last whole line; a quoted cell that is still open at the end, and not longer, is in none."""
    open_cell = _OPEN_CELL.search(text, max(len(text) - longest, 0))
    return text.rfind(b"\n", 0, open_cell.start() if open_cell else None) + 1
