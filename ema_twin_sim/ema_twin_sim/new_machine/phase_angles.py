"""Angles between voltage and current, as a power analyser gives them beside its powers: no positions of a shaft."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from ema_bench_replay.traces.header_words import HeaderWords

from .column_quantity import has_word
from .column_words import BETWEEN_VOLTAGE_AND_CURRENT, REACTIVE_OR_APPARENT

_SYMBOL = "phi"


def phase_angles(names: Sequence[HeaderWords], families: Collection[tuple[str, ...]] = ()) -> tuple[str, ...]:
    """The names of columns that hold such angles.

    They say so, or ``PHI`` stands where another column, such as ``PA1_S_2 [VA]`` beside ``PA1_PHI_2``, has the symbol
    of a reactive or apparent power by its unit, or with other words of the ``families`` of an analyser's columns.
    Nothing that turns has these powers; one in W may be a shaft's.
    """
    beside = {rest for read in names if _is_power(read) for rest in _without_a_word(read.words)} | {*families}
    return tuple(
        read.name
        for read in names
        if read.quantity in (None, "position")
        and (has_word(read.words, BETWEEN_VOLTAGE_AND_CURRENT) or _without_symbol(read.words) in beside)
    )


def _is_power(read: HeaderWords) -> bool:
    """Whether a column is a reactive or an apparent power by its unit."""
    return re.fullmatch(REACTIVE_OR_APPARENT, read.foreign) is not None


def _without_a_word(words: tuple[str, ...]) -> list[tuple[str, ...]]:
    """What is left of a name without each of its words in turn."""
    return [words[:place] + words[place + 1 :] for place in range(len(words))]


def _without_symbol(words: tuple[str, ...]) -> tuple[str, ...] | None:
    """What is left of a name without the angle's symbol; None if it has none."""
    return tuple(word for word in words if word != _SYMBOL) if _SYMBOL in words else None
