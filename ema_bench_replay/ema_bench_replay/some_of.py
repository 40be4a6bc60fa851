"""The first few of many names, for a message of one line."""

from __future__ import annotations

from collections.abc import Iterable


def some_of(names: Iterable[str], length: int = 60) -> str:
    """``a, b, c and 9 more``: as many as go into so many characters, one at least; a longer name is cut."""
    left = [name if len(name) <= length else f"{name[: length - 1]}…" for name in names]
    shown: list[str] = []
    while left and (not shown or len(", ".join([*shown, left[0]])) <= length):
        shown.append(left.pop(0))
    more = f" and {len(left)} more" if left else ""
    return ", ".join(shown) + more
