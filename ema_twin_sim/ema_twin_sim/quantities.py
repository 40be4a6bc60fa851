"""Quantities as engineers write them: three digits, an SI prefix, a unit."""

from __future__ import annotations

import math

_PREFIXES = ((1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"))


def quantity(value: float | None, unit: str, digits: int = 3) -> str:
    """``0.00301, 'A'`` as ``3.01 mA``; a dash where there is no value."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0.0:
        return f"0 {unit}"
    scale, prefix = next(
        ((s, p) for s, p in reversed(_PREFIXES) if abs(value) >= s * (1.0 - 0.5 * 10.0**-digits)), _PREFIXES[0]
    )
    number = value / scale
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(number)))) if number else 0
    return f"{number:.{decimals}f} {prefix}{unit}"
