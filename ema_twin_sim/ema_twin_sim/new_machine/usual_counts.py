"""The counts per turn of encoders that makers offer."""

from __future__ import annotations

from ..criteria import NEGLIGIBLE

_LINES = (100, 125, 128, 250, 256, 360, 400, 500, 512, 600, 625, 720, 900, 1000, 1024, 1250, 1500, 1800, 2000)
"""Lines of usual encoders; finer ones have powers of two, or these times ten or a hundred."""


def usual_counts(counts: float) -> float | None:
    """The counts per turn of the usual encoder that agrees within ``NEGLIGIBLE`` / 4; None if there is none."""
    powers = [2.0**k for k in range(6, 33)]
    lines = [float(n * times * 10**more) for n in _LINES for times in (1, 4) for more in (0, 1, 2)]
    nearest = min((*powers, *lines), key=lambda usual: abs(counts / usual - 1.0))
    return nearest if abs(counts / nearest - 1.0) < NEGLIGIBLE / 4.0 else None
