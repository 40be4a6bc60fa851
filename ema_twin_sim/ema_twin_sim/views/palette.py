"""The colours of the views: those of the report on a dark background, as rerun's viewer has it."""

from __future__ import annotations

Colour = tuple[int, int, int]

GROUND: Colour = (13, 16, 17)
TEXT: Colour = (230, 233, 236)
QUIET: Colour = (163, 173, 183)
RULE: Colour = (58, 66, 75)
GRID: Colour = (34, 39, 45)
BENCH: Colour = (240, 242, 244)
MEASURED: Colour = (145, 156, 167)
"""Measured curves in rerun's own charts, whose background is dark or light like the desktop."""
BEFORE: Colour = (255, 154, 77)
AFTER: Colour = (93, 184, 245)
FITTED: Colour = (255, 122, 198)
MODELS = (BEFORE, AFTER, FITTED)
"""The colours of models, the earliest first."""
RIVAL: Colour = (199, 155, 230)
FAINT: Colour = (125, 135, 145)
GOOD: Colour = (90, 208, 122)

NAMED = {
    "bench": BENCH,
    "before": BEFORE,
    "after": AFTER,
    "fitted": FITTED,
    "rival": RIVAL,
    "faint": FAINT,
    "band": FAINT,
}
"""The colours that the report's charts name."""
_DIM = 0.28  # opacity of a colour behind others


def dimmed(colour: Colour) -> Colour:
    """A colour blended with the background."""
    red, green, blue = (round(g + _DIM * (c - g)) for c, g in zip(colour, GROUND, strict=True))
    return red, green, blue


def named(role: str) -> Colour:
    """The colour of a role in the report's charts: ``@before``, ``@before-faint``."""
    name, _, faint = role.removeprefix("@").partition("-")
    return dimmed(NAMED[name]) if faint else NAMED[name]
