"""A text file as blocks of whole lines in ASCII-compatible bytes, from any Windows encoding."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import BinaryIO

_BLOCK = 4 << 20
_LONGEST_LINE = 1 << 20
_BOMS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}


class NotText(ValueError):
    """The file holds no lines of text."""


def text_blocks(file: BinaryIO) -> Iterator[tuple[bytes, bool]]:
    """Blocks of whole lines, each with whether it is the last. Only the last one may lack a line end.

    Byte order marks and carriage returns are removed, UTF-16 is converted to UTF-8; other encodings stay unchanged,
    since digits are the same in all of them. Raises NotText if a line does not end.
    """
    start = file.read(4)
    file.seek(0)
    encoding = next((name for bom, name in _BOMS.items() if start.startswith(bom)), None)
    if encoding is None and len(start) == 4 and start[1::2] == b"\0\0":
        encoding = "utf-16-le"
    if encoding == "utf-8-sig":
        file.seek(3)
    elif encoding:
        # A truncated file may end inside a character: such a line holds no complete row anyway.
        file = io.BytesIO(file.read().decode(encoding, errors="replace").encode())
    waiting, carry = b"", b""
    while chunk := file.read(_BLOCK):
        chunk = carry + chunk.translate(None, b"\r")
        end = chunk.rfind(b"\n") + 1
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
