"""Text with blank-separated columns: each run of blanks becomes a tab, so that the other code reads it as usual.

Names may contain blanks if two or more blanks separate them, if they are in quotation marks, or if a unit in brackets
follows each: ``time [s]  motor position [rad]``.
"""

from __future__ import annotations

import re

from ema_bench_replay.traces.text_blocks import MOST_LINES

_NUMBER = re.compile(rb"[-+]?(?:\d[\d.,]*|[.,]\d+)(?<![.,])(?:[eE][-+]?\d+)?|[-+]?\d+\.|[-+]?nan", re.IGNORECASE)
_WORD = re.compile(rb"[^,]+")
_COMMENT = re.compile(r"\s*[#%]+\s*")


def with_tabs(block: bytes) -> bytes:
    """A text's first block with tabs in place of separating blanks; unchanged if there is another separator."""
    lines = block.split(b"\n", MOST_LINES)
    first = lines[:MOST_LINES]  # what follows is many lines in one, which may look like a single row
    rows = next((k for k in range(len(first)) if _begins_rows(first, k)), None)
    if rows is None:
        return block
    width = len(lines[rows].split())
    above = [_above_rows(line, width) for line in lines[:rows]]
    return b"\n".join([*above, rows_with_tabs(b"\n".join(lines[rows:]))])


def rows_with_tabs(block: bytes) -> bytes:
    """Rows of numbers with a tab for each run of blanks."""
    return re.sub(rb" +", b"\t", re.sub(rb"^ +| +$", b"", block, flags=re.MULTILINE))


def _begins_rows(lines: list[bytes], k: int) -> bool:
    """Whether rows of numbers begin at a line: two of equal width, or a single last one."""
    if not _is_row(lines[k]):
        return False
    after = next((line for line in lines[k + 1 :] if line.strip()), None)
    return after is None or (_is_row(after) and len(after.split()) == len(lines[k].split()))


def _is_row(line: bytes) -> bool:
    """Whether a line begins with a number and holds at least two, with only words between them."""
    if b";" in line or b"\t" in line:
        return False
    cells = line.split()
    numbers = [_NUMBER.fullmatch(cell) is not None for cell in cells]
    words = (cell for cell, number in zip(cells, numbers, strict=True) if not number)
    return sum(numbers) > 1 and numbers[0] and all(map(_WORD.fullmatch, words))


def _above_rows(line: bytes, width: int) -> bytes:
    """A line above the rows, with tabs between its names if there are ``width`` of them."""
    text = line.decode("utf-8", "surrogateescape")
    mark = found[0] if (found := _COMMENT.match(text)) else ""
    names = _names(text[len(mark) :].strip(), width)
    return line if names is None else (mark + "\t".join(names)).encode("utf-8", "surrogateescape")


def _names(text: str, width: int) -> list[str] | None:
    """The ``width`` names of a line; None if it cannot be split into so many."""
    if any(mark in text for mark in ";\t"):
        return None
    for pattern in (r'"[^"]*"|\S+', r"(?:\S| (?! ))+", r"[^\[({]*?(?:\[[^\]]*\]|\([^)]*\)|\{[^}]*\})", r"[^,]+"):
        names = [found.strip() for found in re.findall(pattern, text)]
        if len(names) == width:
            return [name.removesuffix(",") for name in names]
    return None
