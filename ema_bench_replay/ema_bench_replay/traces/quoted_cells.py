"""Words in quotation marks may hold the mark that separates cells ("Speed, motor [rpm]"); it separates nothing there.

A number may be quoted too ("1,5"); its marks belong to the number format and are left to it.
"""

from __future__ import annotations

import re

_QUOTED = re.compile(rb'(?:(?<=[,;\t\n])|(?<=[,;\t] )|\A)"([^"\n]*[,;\t][^"\n]*)"(?=[ \r]*(?:[,;\t\n]|\Z))')
_NUMBER = re.compile(rb"[-+0-9.,;' \teE%]*")
_WRITTEN = b",;\t"
_STANDS_FOR = b"\x11\x12\x13"
"""Control characters that no text holds and that are no blanks."""


def with_marks_hidden(block: bytes) -> bytes:
    """A text in which other characters stand for the separating marks inside quoted words."""
    return _QUOTED.sub(_hidden, block) if b'"' in block else block


def with_marks_shown(name: str) -> str:
    """A cell as it was written."""
    return name.translate(dict(zip(_STANDS_FOR, _WRITTEN.decode(), strict=True)))


def _hidden(found: re.Match[bytes]) -> bytes:
    if _NUMBER.fullmatch(found[1]):
        return found[0]
    return found[0].translate(bytes.maketrans(_WRITTEN, _STANDS_FOR))
