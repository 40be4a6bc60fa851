"""Which signals of a comparison tell something, which stand out of the sensors' noise, and shares: told alike."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..criteria import NOISY, SMALL

if TYPE_CHECKING:
    from .running_comparison import SignalError

OPEN_LOOP = ("speed", "motor_position", "output_position")
"""Signals that drift under the input ``current``, where nothing holds the twin's motion to the bench's."""


def shown_signals(source: str, signals: Mapping[str, SignalError]) -> list[str]:
    """Of signals that were compared, those whose errors tell something under an input."""
    left_out = OPEN_LOOP if source == "current" else ()
    return [name for name, signal in signals.items() if not signal["driven"] and name not in left_out]


def times_noise(error: SignalError) -> float:
    """An RMSE over its noise floor; infinite where the sensor has none."""
    return error["rmse"] / error["noise_floor"] if error["noise_floor"] > 0.0 else math.inf


def is_noise(error: SignalError) -> bool:
    """Whether an RMSE is the sensors' noise, to a tenth of it."""
    return error["rmse"] <= (1.0 + SMALL) * error["noise_floor"]


def beyond_noise(source: str, signals: Mapping[str, SignalError]) -> dict[str, float]:
    """By signal that stands out of its noise, its RMSE over its noise floor, the worst first.

    Where a setpoint drives the twin, the current tells of torques what the unexplained torque would.
    """
    judged = [name for name in shown_signals(source, signals) if source == "current" or name != "unexplained_torque"]
    over = {name: times_noise(signals[name]) for name in judged if times_noise(signals[name]) > NOISY}
    return dict(sorted(over.items(), key=lambda item: -item[1]))


def times_words(times: float) -> str:
    """``5.0 times``, ``42 times``."""
    digits = max(0, 1 - int(math.log10(max(times, 1.0))))
    return f"{times:.{digits}f} times"


def told_share(share: float) -> float:
    """A share as it is told, from 0 to 1: what makes an error grow takes none of it away."""
    return min(max(share, 0.0), 1.0)
