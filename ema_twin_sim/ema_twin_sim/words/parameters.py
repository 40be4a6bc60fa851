"""Parameters of effects as rows of a table: an effect's name and options stand in the row of its first one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

from .sentences import effect_words, options_words

Held = TypeVar("Held")


def parameter_rows(
    name: str, options: Mapping[str, str], parameters: Mapping[str, Held]
) -> Iterator[tuple[tuple[str, str], str, Held]]:
    """((effect, options) or blanks, parameter, what is held of it) of each parameter of an effect."""
    first = (effect_words(name), options_words(options))
    for parameter, held in parameters.items():
        yield first, parameter, held
        first = ("", "")


def numbers_of(entry: Mapping[str, Held]) -> dict[str, Held]:
    """The parameters of an effect's entry in findings, which holds its id and options too."""
    return {name: held for name, held in entry.items() if name not in ("effect", "options")}
