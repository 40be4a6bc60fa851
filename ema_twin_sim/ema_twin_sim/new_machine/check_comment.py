"""The mark of what a draft could not know: whoever uses it looks at every line that says so."""

from __future__ import annotations

CHECK = "CHECK"


def check_comment(doubt: str) -> str:
    """The comment at the end of a line, with what is in doubt of it; empty where nothing is."""
    return f"  # {CHECK}: {doubt}" if doubt else ""
