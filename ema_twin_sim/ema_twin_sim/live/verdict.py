"""How well a twin follows its bench, in one word. No ROS."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from enum import IntEnum

from ..quantities import quantity


class Level(IntEnum):
    """Numbered as in `ema_twin_msgs/Health`."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


def level_of(
    rmse: Mapping[str, float],
    noise_floor: Mapping[str, float],
    driven: Collection[str],
    warn_at: float,
    error_at: float,
) -> tuple[Level, str]:
    """The level of the worst signal, by its RMSE over its noise floor, and that signal in words.

    Signals with RMSE NaN do not count. The `driven` ones do not count either: they are the twin's input. STALE if no
    signal is left.
    """
    worst, ratio = "", -1.0
    for name, floor in noise_floor.items():
        if name not in driven and floor > 0.0 and rmse[name] / floor > ratio:
            worst, ratio = name, rmse[name] / floor
    if not worst:
        return Level.STALE, "nothing compared yet"
    words = f"{worst.replace('_', ' ')}: RMSE is {ratio:.3g} times the noise floor"
    if ratio >= error_at:
        return Level.ERROR, words
    return (Level.WARN if ratio >= warn_at else Level.OK), words


def errors_in_words(
    rmse: Mapping[str, float], noise_floor: Mapping[str, float], units: Mapping[str, str]
) -> dict[str, str]:
    """The RMSE of each signal as text for the diagnostics; signals that were not compared are left out."""
    words = {}
    for name, value in rmse.items():
        if math.isfinite(value):
            floor = noise_floor[name]
            times = f", {value / floor:.3g} times the noise floor" if floor > 0.0 else ""
            words[f"RMSE of the {name.replace('_', ' ')}"] = f"{quantity(value, units[name])}{times}"
    return words
