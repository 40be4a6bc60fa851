"""A text file as blocks of whole lines in ASCII-compatible bytes, from any Windows encoding."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import BinaryIO

from ema_bench_replay.traces.line_breaks import (
    end_of_lines,
    has_lone_returns,
    returns_as_feeds,
    without_breaks_in_cells,
)

MOST_LINES = 200
"""Lines among which the first row of numbers must be."""
_BLOCK = 4 << 20
_LONGEST_LINE = 1 << 20
_LOOKED_AT = 1 << 16  # bytes at the beginning that tell whether it is text
_MOST_CONTROLS = 0.05  # of these, control characters that no text needs; random bytes have 0.11
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r\x1a"))
_BOMS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}


class NotText(ValueError):
    """The file holds no lines of text, or none that end."""


def text_blocks(file: BinaryIO) -> Iterator[tuple[bytes, bool]]:
    """Blocks of whole lines, each with whether it is the last. Only the last one may lack a line end.

    Byte order marks and carriage returns are removed, UTF-16 is converted to UTF-8; other encodings stay unchanged,
    since digits are the same in all of them. Where carriage returns alone end the rows, line feeds do instead. A line
    break inside a quoted cell is a blank: such a row is one line, as in a spreadsheet. Raises NotText if a line does
    not end, or if the file is binary.
    """
    start = file.read(4)
    file.seek(0)
    encoding = next((name for bom, name in _BOMS.items() if start.startswith(bom)), None)
    if encoding is None and len(start) == 4 and start[1::2] == b"\0\0":
        encoding = "utf-16-le"
    if encoding not in (None, "utf-8-sig"):
        # A truncated file may end inside a character: such a line holds no complete row anyway.
        file = io.BytesIO(file.read().decode(encoding, errors="replace").encode())
    waiting, carry = b"", b""
    begin = file.read(_LOOKED_AT)
    if _is_binary(begin):
        raise NotText
    lone = has_lone_returns(begin)
    file.seek(3 if encoding == "utf-8-sig" else 0)
    while chunk := file.read(_BLOCK):
        if lone and chunk.endswith(b"\r"):
            chunk += file.read(1)  # perhaps the line feed that goes with it
        chunk = carry + (returns_as_feeds(chunk) if lone else chunk.translate(None, b"\r"))
        end = chunk.rfind(b"\n") + 1
        if b'"' in chunk:
            chunk = without_breaks_in_cells(chunk)
            end = end_of_lines(chunk, _LONGEST_LINE // 2)
        block, carry = chunk[:end], chunk[end:]
        if len(carry) > _LONGEST_LINE:
            raise NotText
        if block:
            if waiting:
                yield waiting, False
            waiting = block
    # A file with preallocated space ends in zeros.
    last = waiting + carry.rstrip(b"\0")
    yield last, True


def _is_binary(start: bytes) -> bool:
    """Whether a file that begins so holds no text; zeros at its end are preallocated space."""
    start = start.rstrip(b"\0")
    return len(start) - len(start.translate(None, _CONTROLS)) > _MOST_CONTROLS * len(start)
