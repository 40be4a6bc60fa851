"""Which quantity the words of a column's name give."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ema_bench_replay.traces.header_words import header_words

from .column_words import ACTUAL, ENCODER, FILTERED, MOTOR, OUTPUT, PRESENT, SETPOINT, STEMS, SYMBOLS


def has_word(words: Sequence[str], pattern: str) -> bool:
    """Whether a regular expression finds any of the words."""
    return any(re.search(pattern, word) for word in words)


def word_quantity(words: Sequence[str]) -> str | None:
    """The quantity that the words give; a position with a dot is a speed."""
    words = _without_present(words)
    symbols = [word for word in words if not _only_numbers(word, words)]
    by_symbol = next((quantity for word in symbols for quantity, known in SYMBOLS.items() if word in known), None)
    found = next((quantity for quantity, pattern in STEMS.items() if has_word(words, pattern)), by_symbol)
    return "speed" if found == "position" and "dot" in words else found


def _without_present(words: Sequence[str]) -> Sequence[str]:
    """The words without one that tells the present value of the position or speed named next, as in ``curr_pos``."""
    moves = f"{STEMS['speed']}|{STEMS['position']}"

    def tells_present(place: int) -> bool:
        """Whether the word there is such a one."""
        after = "".join(words[place + 1 : place + 2])
        is_motion = re.search(moves, after) is not None and re.search(ENCODER, after) is None
        return is_motion and re.search(PRESENT, words[place]) is not None

    return [word for place, word in enumerate(words) if not tells_present(place)]


def _only_numbers(letter: str, words: Sequence[str]) -> bool:
    """Whether a letter only numbers what the words name, as in ``m1foo``: of a motor, a sensor, an axis."""
    if len(letter) > 1 or len(words) < 3 or words[0] != letter or not words[1].isdigit():
        return False
    known = f"{SETPOINT}|{ACTUAL}|{OUTPUT}|{MOTOR}|{FILTERED}|^(dot|raw|\\d+)$"
    return not all(re.search(known, word) for word in words[2:])


def contradicted_quantity(name: str, unit: str | None = None) -> str:
    """The quantity that a column's words give if its unit is clearly of another one; empty if both agree.

    ``unit`` is the one in which it is read, if that is known.

    Not a contradiction: a torque in amperes, and a speed of an encoder. Symbols of one letter are not considered.
    """
    read = header_words(name)
    said = {quantity for quantity, pattern in STEMS.items() if has_word(read.words, pattern)}
    in_doubt = read.in_doubt and read.unit != unit
    if read.quantity is None or in_doubt or not said or read.quantity in said:
        return ""
    if read.quantity == "current" and "torque" in said:
        return ""
    if read.quantity == "speed" and has_word(read.words, ENCODER + r"|dot"):
        return ""
    return next(quantity for quantity in STEMS if quantity in said)
