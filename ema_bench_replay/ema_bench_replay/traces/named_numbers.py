"""Rows that name each of their numbers, as microcontrollers print them: ``Time: 5001 Position: 599 Current: 518``.

The names become the header, and tabs stand between the numbers, so that the other code reads them as usual.
"""

from __future__ import annotations

import re
from itertools import pairwise

from ema_bench_replay.traces.text_blocks import MOST_LINES

_WORD = rb"[^:=,;\s]"
_NUMBER = rb"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?|nan|[-+]?inf"
_PAIR = re.compile(  # a name of a few words, one blank between them, so that no long line takes long
    rb"[ \t,;]*([^\W\d]" + _WORD + rb"{0,40}(?: " + _WORD + rb"{1,40}){0,7})[ \t]*[:=][ \t]*"
    rb"(" + _NUMBER + rb")(?=[ \t,;\r]|$)",
    re.IGNORECASE,
)
Names = tuple[bytes, ...]


def named_numbers(block: bytes) -> tuple[bytes, Names] | None:
    """A text's first block with a header in place of the names in its rows, and these; None if rows hold no names.

    Two rows or more must follow each other that name the same two numbers or more.
    """
    lines = block.split(b"\n")
    rows = [(k, *found) for k, line in enumerate(lines[:MOST_LINES]) if (found := _pairs(line)) is not None]
    for (k, names, _), (after, others, _) in pairwise(rows):
        if names == others and len(names) > 1 and not b"".join(lines[k + 1 : after]).strip():
            below = without_names(b"\n".join(lines[k:]), names)
            return b"\n".join([*lines[:k], b"\t".join(names), below]), names
    return None


def without_names(block: bytes, names: Names) -> bytes:
    """Rows with tabs between their numbers. A blank line is one without numbers; any other is a single cell."""
    *above, last = block.split(b"\n")
    empty = b"\t" * (len(names) - 1)
    return b"\n".join([*(_row(line, names) or empty for line in above), _row(last, names)])


def _row(line: bytes, names: Names) -> bytes:
    found = _pairs(line)
    return b"\t".join(found[1]) if found is not None and found[0] == names else line.strip().replace(b"\t", b" ")


def _pairs(line: bytes) -> tuple[Names, tuple[bytes, ...]] | None:
    """The names and the numbers of a row; None if it holds anything else."""
    found, end = [], 0
    while (pair := _PAIR.match(line, end)) is not None:
        found.append(pair.groups())
        end = pair.end()
    if not found or line[end:].strip(b" \t,;\r"):
        return None
    return tuple(name for name, _ in found), tuple(number for _, number in found)
