"""Rows that end in a semicolon beside another separator, as MATLAB writes a matrix: the semicolon is no column."""

from __future__ import annotations

import re

from ema_bench_replay.traces.text_blocks import MOST_LINES

_NUMBER = re.compile(rb"[-+]?(\d+[.,]?\d*|[.,]\d+)([eE][-+]?\d+)?|[-+]?nan", re.IGNORECASE)
_SEPARATORS = re.compile(rb"[ \t]*,[ \t]*|\t| +")
_COMMENTS = (b"#", b"%")


def without_row_ends(block: bytes) -> bytes:
    """A text's first block without the semicolons at the ends of its rows; unchanged if they do not all have one."""
    if b";" not in block:
        return block
    lines = [line.strip() for line in block.split(b"\n", MOST_LINES)[:MOST_LINES]]
    begin = next((k for k, line in enumerate(lines) if _is_ended_row(line)), None)
    if begin is None:
        return block
    rows = [line for line in lines[begin:-1] if line and not line.startswith(_COMMENTS)]  # the last one may be cut
    return rows_without_ends(block) if all(map(_is_ended_row, rows)) else block


def rows_without_ends(block: bytes) -> bytes:
    """Lines without a semicolon at their ends."""
    return re.sub(rb";[ \t]*$", b"", block, flags=re.MULTILINE)


def _is_ended_row(line: bytes) -> bool:
    """Whether a line holds several numbers between other separators, and its only semicolon ends it."""
    if not line.endswith(b";") or line.count(b";") > 1:
        return False
    cells = _SEPARATORS.split(line[:-1].strip())
    if len(cells) == 2 and b"," in line and b"." not in line:
        return False  # a single number with a decimal comma
    return len(cells) > 1 and all(map(_NUMBER.fullmatch, cells))
