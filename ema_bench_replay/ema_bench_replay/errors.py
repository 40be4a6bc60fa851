"""The one exception for input that cannot be used."""

from __future__ import annotations

LONGEST = 290
"""Characters of its text: a line of a log, with what is put before it."""
_END = 110  # of them that stay of the text's end, where the remedy is


class InputError(ValueError):
    """Input refused. Its text is one line, `FILE: place: what is wrong; what to do`.

    The command line prints it and ends with status 2. What it quotes of the input may be anything: characters that a
    terminal would obey are written as their codes, and of a long text the middle is left out.
    """

    def __init__(self, text: object) -> None:
        super().__init__(one_line(str(text)))


def one_line(text: str) -> str:
    """The text as one line of at most LONGEST printable characters."""
    if not text.isprintable():
        text = "".join(map(_printable, text))
    return text if len(text) <= LONGEST else f"{text[: LONGEST - _END - 3]} … {text[-_END:]}"


def _printable(character: str) -> str:
    if character.isprintable():
        return character
    return " " if character.isspace() else character.encode("unicode_escape").decode()
