"""How errors of signals are written in tables, and which of them tell something."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..quantities import quantity

if TYPE_CHECKING:
    from ..comparison.running_comparison import SignalError

AT_NOISE = 1.1
"""An RMSE up to this many noise floors counts as the sensors' noise."""
ALL = "all recordings"
"""The name of the row that pools them."""
OPEN_LOOP = ("speed", "motor_position", "output_position")
"""Signals that drift under the input ``current``, where nothing holds the twin's motion to the bench's."""


def shown_signals(source: str, signals: Mapping[str, SignalError]) -> list[str]:
    """The signals whose errors tell something under an input."""
    left_out = OPEN_LOOP if source == "current" else ()
    return [name for name, signal in signals.items() if not signal["driven"] and name not in left_out]


def error_cell(signal: SignalError | None) -> str:
    """An RMSE, green where it is the sensors' noise; a dash where there is none."""
    if signal is None:
        return "–"
    ratio = signal["rmse"] / signal["noise_floor"] if signal["noise_floor"] else math.inf
    style = "green" if ratio <= AT_NOISE else ("yellow" if ratio <= 3.0 else "red")
    return f"[{style}]{quantity(signal['rmse'], signal['unit'])}[/{style}]"


def noise_cell(signal: SignalError | None) -> str:
    """The sensors' noise in a signal."""
    return "–" if signal is None else quantity(signal["noise_floor"], signal["unit"])
