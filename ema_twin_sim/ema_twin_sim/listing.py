"""Listing: several things in a sentence, and how many there are."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def listed(words: Iterable[str], last: str = "and") -> str:
    """``a, b and c``."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end


def first_of(names: Sequence[str]) -> str:
    """``a and 3 more``; ``a`` alone if there are no others."""
    return f"{names[0]} and {len(names) - 1} more" if len(names) > 1 else names[0]


def number_of(count: int, one: str) -> str:
    """``1 line``, ``3 lines``."""
    return f"{count} {one}" if count == 1 else f"{count} {one}s"
