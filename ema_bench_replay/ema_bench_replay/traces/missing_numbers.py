"""What programs write for a number that they do not have: a value of a row, and no name of a column."""

from __future__ import annotations

import re
from collections.abc import Sequence

_MISSING = re.compile(r"[-+]?(?:nan(?:\(\w*\))?|inf(?:inity)?)|#?n/?a|null|none", re.IGNORECASE)


def is_missing(cell: str) -> bool:
    """Whether a cell says that a number is missing; an empty one says nothing."""
    return _MISSING.fullmatch(cell) is not None


def holds_nothing(cells: Sequence[str]) -> bool:
    """Whether each of several cells of a row is empty or says that a number is missing."""
    return len(cells) > 1 and all(not cell or is_missing(cell) for cell in cells)
