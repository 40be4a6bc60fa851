"""The mark of what is only assumed in a file: its user has to look at every line with this mark."""

from __future__ import annotations

CHECK = "CHECK"
ASSUMED = "assumed"
"""The word by which the source of a constant says that nobody measured it."""
START_VALUE = "start value"
"""The source of a constant of which nothing is known yet: a fit begins there, and nobody said that it is so large."""
REMEDIES = {
    "machine.gear_ratio": "turns of the motor per turn of the output",
    "machine.torque_constant": "take it from the motor's data sheet",
}
"""By path, the constants that have the mark while they are assumed, and how to replace the assumption."""


def check_comment(doubt: str) -> str:
    """Comment at the end of a line that says what is in doubt about it; empty if nothing is."""
    return f"  # {CHECK}: {doubt}" if doubt else ""


def is_assumed(source: str) -> bool:
    """Whether the source of a constant says that it is assumed."""
    return any(part.strip().lower().startswith(ASSUMED) for part in source.split(";"))
