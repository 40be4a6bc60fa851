"""The mark of what a draft could not know: its user has to look at every line with this mark."""

from __future__ import annotations

CHECK = "CHECK"


def check_comment(doubt: str) -> str:
    """Comment at the end of a line that says what is in doubt about it; empty if nothing is."""
    return f"  # {CHECK}: {doubt}" if doubt else ""
