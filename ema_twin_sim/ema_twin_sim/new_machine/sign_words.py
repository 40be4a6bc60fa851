"""How a map turns a drive's sign, in words: by a factor of -1, or by the sign of a factor that is there already."""

from __future__ import annotations

from collections.abc import Sequence

from .columns import Guess


def how_to_turn(drive: Sequence[Guess]) -> str:
    """What to do about a wrong sign of these columns; the line of the map follows."""
    return "change the sign of `factor` in" if _has_a_factor(drive) else "add `factor: -1` to"


def how_it_is_turned(drive: Sequence[Guess]) -> str:
    """What the map says of these columns, whose sign it reverses."""
    return "a negative `factor`" if _has_a_factor(drive) else "`factor: -1`"


def _has_a_factor(drive: Sequence[Guess]) -> bool:
    """Whether their lines have the size of a servo's step."""
    return any(guess.factor != 1.0 for guess in drive)
