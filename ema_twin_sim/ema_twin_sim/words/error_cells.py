"""How errors of signals are written in tables."""

from __future__ import annotations

from ..comparison.beyond_noise import is_noise, times_noise
from ..comparison.closeness import Closeness
from ..comparison.running_comparison import SignalError
from ..criteria import TOO_MUCH
from ..quantities import MOST_TIMES, limited_factor, quantity

ALL = "all recordings"
"""Name of the row of all recordings together."""


def error_cell(signal: SignalError | None) -> str:
    """An RMSE: green within the sensors' noise, yellow up to ``TOO_MUCH`` times it, else red; a dash if missing."""
    if signal is None:
        return "–"
    style = "green" if is_noise(signal) else ("yellow" if times_noise(signal) <= TOO_MUCH else "red")
    return f"[{style}]{quantity(signal['rmse'], signal['unit'])}[/{style}]"


def noise_cell(signal: SignalError | None) -> str:
    """The sensors' noise in a signal."""
    return "–" if signal is None else quantity(signal["noise_floor"], signal["unit"])


def closeness_cell(closeness: Closeness | None) -> str:
    """``14.6 ×``; ``≥ 22 ×`` if the closer model's error is lost in the noise; a dash if both errors are.

    ``over 1000 ×`` if it is more than that, which happens where a model is a draft.
    """
    if closeness is None:
        return "–"
    sign = {"at_least": "≥ ", "at_most": "≤ "}.get(closeness.bound, "")
    if not 1.0 / MOST_TIMES <= closeness.times <= MOST_TIMES:
        sign = ""  # said with the limit
    return f"{sign}{number_of_times(closeness.times)} ×"


def number_of_times(times: float) -> str:
    """A ratio with two decimals below 1, one below 100, none above, and a limit beyond 1000."""
    return limited_factor(times, f".{2 if times < 0.995 else (1 if times < 99.5 else 0)}f")
