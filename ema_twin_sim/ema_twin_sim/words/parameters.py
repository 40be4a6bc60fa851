"""Parameters of effects as rows of a table; the first row of an effect has its name and options."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

from .sentences import effect_words, options_words

Held = TypeVar("Held")


def parameter_rows(
    name: str, options: Mapping[str, str], parameters: Mapping[str, Held]
) -> Iterator[tuple[tuple[str, str], str, Held]]:
    """Yield ((effect, options) or blanks, parameter, its value) for each parameter of an effect."""
    first = (effect_words(name), options_words(options))
    for parameter, held in parameters.items():
        yield first, parameter, held
        first = ("", "")


def numbers_of(entry: Mapping[str, Held]) -> dict[str, Held]:
    """The parameters in an effect's entry of findings, without its id and options."""
    return {name: held for name, held in entry.items() if name not in ("effect", "options")}
