"""Which part of a machine a column's name tells: what is left of it without its quantity, its unit and its side.

``FL_hip_torque`` is of FL hip, and ``X_ActualPosition`` of X. Motor and output are sides of one part, so their words
tell none; nor do those of measurement and setpoint.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from ema_bench_replay.traces.header_words import HeaderWords

from .column_quantity import has_word, word_quantity
from .column_words import OF_A_SYMBOL, OF_NO_PART, SENSOR_SERIES, STEMS, SYMBOLS

_AXIS = ("axis", "achse")
_LONG_SYMBOLS = frozenset(word for known in SYMBOLS.values() for word in known if len(word) > 1)


def part_of(read: HeaderWords, quantity: str | None, *, load: bool = True) -> tuple[str, ...]:
    """The words of a column's name that tell its part, with a number that may be in brackets; empty without.

    A symbol is left out only if it is what tells the ``quantity``: the X of ``X_position`` tells an axis. ``load``:
    whether ``l`` is the load's side; beside ``r`` it is the left.
    """
    words = [*without_type(read.words), read.foreign] if read.foreign.isdigit() else [*without_type(read.words)]
    symbol = None if is_told(read) else next((word for word in words if word in SYMBOLS.get(quantity or "", ())), None)
    of_current = quantity in ("current", "voltage")
    if of_current:  # the quadrature axis is none of the machine's
        words = [word for k, word in enumerate(words) if not (word in _AXIS and words[max(0, k - 1)] in ("d", "q"))]
    return tuple(
        word
        for word in words
        if word.isdigit()
        or not (
            word == symbol
            or word in _LONG_SYMBOLS
            or (of_current and word == "q" and len(words) > 1)
            or (re.search(OF_NO_PART, word) and (load or word != "l"))
        )
    )


def without_type(words: Sequence[str]) -> list[str]:
    """A name's words without the numbers behind a sensor's series, which tell its type: 605 and 5 of ``trs605-5``."""
    kept: list[str] = []
    of_series = False
    for word in words:
        of_series = re.search(SENSOR_SERIES, word) is not None or (of_series and word.isdigit())
        if not (of_series and word.isdigit()):
            kept.append(word)
    return kept


def part_in_the_name(part: Sequence[str], name: str) -> str:
    """A part's words as they are written in a column's name: ``EccA-1`` if only hyphens part them there, else apart."""
    row = "-?".join(map(re.escape, part))
    if part and (found := re.search(rf"(?<![A-Za-z0-9]){row}(?![A-Za-z0-9])", name, re.IGNORECASE)):
        return found[0]
    return " ".join(_as_written(word, name) for word in part)


def without_lone_letters(names: Sequence[HeaderWords]) -> Iterator[HeaderWords]:
    """Yield the names, without a letter that would be the only symbol of a quantity among words that tell none.

    Such as the M of ``M_sequence_number``. A part's name is no such words: other quantities have it too, as ``i_knee``
    beside ``q_knee``.
    """
    quantities: dict[tuple[str, ...], set[str]] = {}
    told = [read.quantity or word_quantity(read.words) for read in names]
    parts = [part_of(read, quantity) for read, quantity in zip(names, told, strict=True)]
    for part, quantity in zip(parts, told, strict=True):
        if quantity:
            quantities.setdefault(part, set()).add(quantity)
    for read, quantity, part in zip(names, told, parts, strict=True):
        letter = next((word for word in read.words if word in SYMBOLS.get(quantity or "", ())), "")
        strange = [word for word in part if not word.isdigit() and not re.search(OF_A_SYMBOL, word)]
        if len(letter) != 1 or is_told(read) or read.foreign or not strange or len(quantities[part]) > 1:
            yield read
        else:
            yield replace(read, words=tuple(word for word in read.words if word != letter))


def is_told(read: HeaderWords) -> bool:
    """Whether a unit or a whole word tells the quantity, so that no symbol is needed."""
    return read.quantity is not None or has_word(read.words, "|".join(STEMS.values()))


def _as_written(word: str, name: str) -> str:
    """A word with its capital letters in a name: where it stands apart, else where it is a part of a longer word."""
    apart = re.search(rf"(?<![a-z]){re.escape(word)}(?![a-z])", name, re.IGNORECASE)
    found = apart or re.search(re.escape(word), name, re.IGNORECASE)
    return found[0] if found else word
