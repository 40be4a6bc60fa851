"""Which signals of a comparison are meaningful, and which exceed the sensors' noise; shares between 0 and 1."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..criteria import NOISY, SMALL
from ..quantities import MOST_TIMES

if TYPE_CHECKING:
    from .running_comparison import SignalError


def shown_signals(source: str, signals: Mapping[str, SignalError]) -> list[str]:
    """The compared signals whose errors are meaningful with a given input."""
    from ..simulation.compared_signals import drifting  # with the whole simulation

    left_out = drifting(source)
    return [name for name, signal in signals.items() if not signal["driven"] and name not in left_out]


def times_noise(error: SignalError) -> float:
    """RMSE over noise floor; infinite if the floor is zero."""
    return error["rmse"] / error["noise_floor"] if error["noise_floor"] > 0.0 else math.inf


def is_noise(error: SignalError) -> bool:
    """Whether an RMSE is only the sensors' noise, within 10 %."""
    return error["rmse"] <= (1.0 + SMALL) * error["noise_floor"]


def beyond_noise(source: str, signals: Mapping[str, SignalError]) -> dict[str, float]:
    """Ratio of RMSE to noise floor for each signal that exceeds its noise, worst first.

    If a setpoint drives the twin, the current contains the information of the unexplained torque, which is left out.
    """
    judged = [name for name in shown_signals(source, signals) if source == "current" or name != "unexplained_torque"]
    over = {name: times_noise(signals[name]) for name in judged if times_noise(signals[name]) > NOISY}
    return dict(sorted(over.items(), key=lambda item: -item[1]))


def times_words(times: float) -> str:
    """Format a ratio: ``5.0 times``, ``42 times``, ``over 1000 times``."""
    if times > MOST_TIMES:
        return f"over {MOST_TIMES:.0f} times"
    digits = max(0, 1 - int(math.log10(max(times, 1.0))))
    return f"{times:.{digits}f} times"


def told_share(share: float) -> float:
    """Limit a share to 0 to 1 for display: a change that increases an error removes none of it."""
    return min(max(share, 0.0), 1.0)
