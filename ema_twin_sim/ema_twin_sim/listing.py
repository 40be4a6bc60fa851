"""Listing: several things in a sentence, and how many there are."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

_MOST = 5  # named in a sentence
_NUMBER = re.compile(r"\d+(\.\d+)?([eE][+-]?\d+)?")


def listed(words: Iterable[str], last: str = "and") -> str:
    """``a, b and c``."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end


def first_of(names: Sequence[str]) -> str:
    """``a and 3 more``; ``a`` alone if there are no others."""
    return f"{names[0]} and {len(names) - 1} more" if len(names) > 1 else names[0]


def few_of(names: Sequence[str]) -> str:
    """``a, b, c, d and 3 more``: at most five."""
    return listed(names if len(names) <= _MOST else [*names[: _MOST - 1], f"{len(names) - _MOST + 1} more"])


def by_recording(warnings: Iterable[str]) -> list[str]:
    """Warnings that begin with a recording's name: one for all recordings with the same, naming up to five of them.

    ``a.csv: text`` and ``b.csv: text`` are ``a.csv and b.csv: text``. If more than five differ only in numbers, the
    first is told, and how many there are.
    """
    of_text: dict[str, list[str]] = {}
    for warning in dict.fromkeys(warnings):
        name, colon, text = warning.partition(": ")
        of_text.setdefault(f"{colon}{text}" if colon else warning, []).append(name if colon else "")
    alike: dict[str, list[tuple[str, list[str]]]] = {}
    for text, names in of_text.items():
        alike.setdefault(_NUMBER.sub("0", text), []).append((text, names))
    found = []
    for told in alike.values():
        if len(told) > _MOST:
            (text, (name, *_)), count = told[0], sum(len(names) for _, names in told)
            found.append(f"{name}{text} (and {count - 1} more like it)")
            continue
        found += [f"{few_of(names)}{text}" for text, names in told]
    return found


def number_of(count: int, one: str) -> str:
    """``1 line``, ``3 lines``."""
    return f"{count} {one}" if count == 1 else f"{count} {one}s"
