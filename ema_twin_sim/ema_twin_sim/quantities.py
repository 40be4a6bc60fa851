"""Quantities as engineers write them: three digits, an SI prefix, a unit."""

from __future__ import annotations

import math

_PREFIXES = ((1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"))
_LEAST_ON_AXIS = 0.3  # of a unit: what goes up to 0.9 rad is drawn in rad, what goes up to 0.2 in mrad
_TWO_DIGITS = 3.0  # a standard error that begins with a smaller digit is given with two


def signal_words(name: str, unit: str = "") -> str:
    """``motor torque``, in ``N`` ``motor force``: a signal's name as people say it, on a carriage too."""
    words = name.replace("_", " ")
    return words.replace("torque", "force") if unit == "N" else words


def quantity(value: float | None, unit: str, digits: int = 3) -> str:
    """``0.00301, 'A'`` as ``3.01 mA``; shares and plain numbers take no prefix; a dash where there is no value."""
    if value is None or not math.isfinite(value):
        return "–"
    if unit in ("1", "%"):
        return f"{value:.{digits}g}{'' if unit == '1' else ' %'}"
    if value == 0.0:
        return f"0 {unit}"
    if abs(value) < 1e-3 * _PREFIXES[0][0]:  # the rounding of a mean, say: no prefix makes it readable
        return f"{value:.{digits - 1}e} {unit}"
    scale, prefix = next(
        ((s, p) for s, p in reversed(_PREFIXES) if abs(value) >= s * (1.0 - 0.5 * 10.0**-digits)), _PREFIXES[0]
    )
    number = value / scale
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(number))))
    return f"{number:.{decimals}f} {prefix}{unit}"


def axis_unit(largest: float, unit: str) -> tuple[float, str]:
    """What to divide numbers up to ``largest`` by so that an axis reads well, and their unit then: ``1e-3, 'mA'``."""
    if not (math.isfinite(largest) and largest > 0.0):
        return 1.0, unit
    fits = ((s, f"{p}{unit}") for s, p in reversed(_PREFIXES) if largest >= _LEAST_ON_AXIS * s)
    return next(fits, (_PREFIXES[0][0], f"n{unit}"))


def estimate(value: float, std: float | None, unit: str) -> str:
    """``0.07968, 0.00085, 'N m'`` as ``79.7 ± 0.8 mN m``: no digit that the standard error makes meaningless.

    Numbers without a unit and masses take no prefix but a power of ten where they need one.
    """
    plain = unit == "1" or unit.startswith("kg")
    if std is None or not math.isfinite(std) or std <= 0.0:
        return f"{value:.4g}{'' if unit == '1' else f' {unit}'}" if plain else quantity(value, unit)
    largest = max(abs(value), std)
    if plain:
        power = math.floor(math.log10(largest))
        scale, prefix = (1.0, "") if -2 <= power <= 3 else (10.0**power, f"e{power}")
    else:
        scale, prefix = next(((s, p) for s, p in reversed(_PREFIXES) if largest >= s), _PREFIXES[0])
    error = std / scale
    decimals = -math.floor(math.log10(error))
    decimals = max(0, decimals + (round(error * 10.0**decimals, 6) < _TWO_DIGITS))
    number = f"{round(value / scale, decimals) + 0.0:.{decimals}f} ± {error:.{decimals}f}"  # 0, not -0
    if plain:
        number = f"({number}){prefix}" if prefix else number
        return number if unit == "1" else f"{number} {unit}"
    return f"{number} {prefix}{unit}"


MOST_TIMES = 1000.0
"""The largest factor that is told as a number: beyond it one side is a draft, or nothing."""


def limited_factor(times: float, digits: str) -> str:
    """A factor in the format ``digits``; beyond ``MOST_TIMES`` ``over 1000``, below its inverse ``under 0.001``."""
    if times > MOST_TIMES:
        return f"over {MOST_TIMES:.0f}"
    if 0.0 <= times < 1.0 / MOST_TIMES:
        return f"under {1.0 / MOST_TIMES:g}"
    return f"{times:{digits}}"
