"""Angles between voltage and current, as a power analyser gives them beside its powers: no positions of a shaft."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from ema_bench_replay.traces.header_words import HeaderWords

from .column_quantity import has_word
from .column_words import BETWEEN_VOLTAGE_AND_CURRENT, REACTIVE_OR_APPARENT

_SYMBOL = "phi"


def phase_angles(names: Sequence[HeaderWords], families: Collection[tuple[str, ...]]) -> tuple[str, ...]:
    """The names of columns that hold such angles.

    They say so, or ``PHI`` stands where another column, such as ``PA1_S_2 [VA]`` beside ``PA1_PHI_2``, has the symbol
    of a reactive or apparent power by its unit, or with other words of the ``families`` of an analyser's columns.
    Nothing that turns has these powers; one in W may be a shaft's.
    """
    powers = [read.words for read in names if re.fullmatch(REACTIVE_OR_APPARENT, read.foreign)]
    beside = {words[:place] + words[place + 1 :] for words in powers for place in range(len(words))} | {*families}

    def is_angle(words: tuple[str, ...]) -> bool:
        rest = tuple(word for word in words if word != _SYMBOL)
        return has_word(words, BETWEEN_VOLTAGE_AND_CURRENT) or (_SYMBOL in words and rest in beside)

    return tuple(read.name for read in names if read.quantity in (None, "position") and is_angle(read.words))
