"""Words with which all columns' names begin, as those of a program or a topic: they tell nothing of one column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ema_bench_replay.traces.header_words import HeaderWords

from .column_quantity import has_word
from .column_words import STEMS


def shared_words(names: Sequence[HeaderWords]) -> int:
    """With how many words all names begin alike; none may consist of these alone."""
    shortest = min((len(read.words) for read in names), default=0)
    if len(names) < 2 or not shortest:
        return 0
    alike = (len({read.words[place] for read in names}) == 1 for place in range(shortest))
    return min(next((place for place, same in enumerate(alike) if not same), shortest), shortest - 1)


def without_shared_quantities(names: Sequence[HeaderWords]) -> list[HeaderWords]:
    """The names without those of the words with which all begin that name a quantity, as in ``current log/position``.

    They stay unless a column's own word names another quantity: a table may hold positions alone.
    """
    count = shared_words(names)
    told = {word for read in names for word in read.words[:count] if _quantities((word,))}
    own = [
        replace(read, words=(*(word for word in read.words[:count] if word not in told), *read.words[count:]))
        for read in names
    ]
    shared = {"time", *_quantities([*told])}
    return own if told and any(_quantities(read.words) - shared for read in own) else [*names]


def _quantities(words: Sequence[str]) -> set[str]:
    """The quantities that words name, not symbols: ``u`` and ``v`` are phases of a current as well."""
    return {quantity for quantity, pattern in STEMS.items() if has_word(words, pattern)}
