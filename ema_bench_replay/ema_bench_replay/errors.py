"""The exception for input that cannot be used, and its kinds."""

from __future__ import annotations

import os
import re

LONGEST = 290
"""Maximum characters of the text, not counting names of existing files: one log line including its prefix."""
_END = 110  # of these, how many are kept from the end of the text, where the remedy is


class InputError(ValueError):
    """Input refused. Its text is one line, `FILE: place: what is wrong; what to do`.

    The command line prints it and ends with status 2. It may quote any input: control characters are written as their
    codes, and the middle of a long text is omitted.
    """

    def __init__(self, text: object) -> None:
        super().__init__(one_line(str(text)))


def one_line(text: str) -> str:
    """The text as one line of at most LONGEST printable characters, not counting names of existing files."""
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


class TimeGoesBackError(InputError):
    """The time of a trace of so many ``rows`` goes back."""

    def __init__(self, message: str, rows: int) -> None:
        super().__init__(message)
        self.rows = rows


class MissingNumberError(InputError):
    """A cell of a trace that must hold a number is empty, or says that it has none."""
