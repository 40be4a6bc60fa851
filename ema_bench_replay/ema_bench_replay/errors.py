"""The one exception for input that cannot be used."""

from __future__ import annotations

import os
import re

LONGEST = 290
"""Characters of its text beside the names of files that exist: a line of a log, with what is put before it."""
_END = 110  # of them that stay of the text's end, where the remedy is


class InputError(ValueError):
    """Input refused. Its text is one line, `FILE: place: what is wrong; what to do`.

    The command line prints it and ends with status 2. What it quotes of the input may be anything: characters that a
    terminal would obey are written as their codes, and of a long text the middle is left out.
    """

    def __init__(self, text: object) -> None:
        super().__init__(one_line(str(text)))


def one_line(text: str) -> str:
    """The text as one line of at most LONGEST printable characters, beside the names of files that exist."""
    if not text.isprintable():
        text = "".join(map(_printable, text))
    if len(text) <= LONGEST:
        return text
    words = (word for word in re.split(r"[\s:;,()']+", text) if os.sep in word)
    files = [word for word in words if os.path.exists(word)]  # noqa: PTH110 (Path.exists raises at a name that is too long)
    longest = LONGEST + sum(map(len, files))
    return text if len(text) <= longest else f"{text[: longest - _END - 3]} … {text[-_END:]}"


def _printable(character: str) -> str:
    if character.isprintable():
        return character
    return " " if character.isspace() else character.encode("unicode_escape").decode()
