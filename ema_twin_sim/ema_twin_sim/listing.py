"""Listing: several things in a sentence, and how many there are."""

from __future__ import annotations

from collections.abc import Iterable


def listed(words: Iterable[str], last: str = "and") -> str:
    """``a, b and c``."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end


def number_of(count: int, one: str) -> str:
    """``1 line``, ``3 lines``."""
    return f"{count} {one}" if count == 1 else f"{count} {one}s"
