"""The numbers that the page quotes: ``0.71<!--forward-->`` is one, named by a comment that no reader sees."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from .number import Number

DOCS = Path(__file__).resolve().parents[1]
PAGE = DOCS / "physics.md"
FOLDER = DOCS / "physics"
QUOTED = re.compile(r"([−-]?\d+(?:\.\d+)?)<!--(\w+)-->")


def quoted(text: str) -> list[tuple[str, str]]:
    """(name, number as written) of everything that a page quotes."""
    return [(name, number) for number, name in QUOTED.findall(text)]


def renewed(text: str, numbers: Mapping[str, Number]) -> str:
    """The page with each quoted number as it was measured now; those that were not, as they are."""
    return QUOTED.sub(lambda at: f"{numbers[at[2]].text}<!--{at[2]}-->" if at[2] in numbers else at[0], text)
