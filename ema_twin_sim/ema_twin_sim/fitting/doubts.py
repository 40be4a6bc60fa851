"""Doubts: whether a fit brought a model nearer to its machine, told from the errors before and after."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

from ..comparison.beyond_noise import is_noise, times_noise, times_words
from ..comparison.running_comparison import SignalError
from ..criteria import NEGLIGIBLE, NOISY, TOO_MUCH
from ..quantities import quantity, signal_words
from ..simulation.compared_signals import drifting
from .unseen import Errors


def no_nearer(
    own_before: Errors, own_after: Errors, before: Errors, after: Errors, *, by_equation: bool, hit: bool
) -> list[str]:
    """A note if signals are farther off after a fit: on its ``own`` recordings, or else where it was not fitted to, if
    their errors grew by more than those of the others shrank.

    A fit that is nearer in the first signal, by which ``compare`` judges models, is not advised against.

    Errors are in the units of the model's file. ``by_equation``: the fit left out standstill, which the errors count;
    ``hit``: teeth meet in the model.
    """
    if farther := _grew(own_before, own_after):
        why = "an effect may be missing: discover tells, if it has not looked yet"
        if by_equation:
            why = "standstill counts here, and a fit leaves it out"
        elif hit:
            why = "teeth that meet 1 ms too early or too late can cause this"
        telling = [signal for signal, error in own_after.items() if tells(signal, error, own_after)]
        nearer = [signal for signal in telling if _is_nearer(own_before[signal], own_after[signal])]
        if telling[0] in nearer:
            return [
                f"the error of the {_both(nearer, own_before, own_after, 'falls')}, but that of the "
                f"{_both(farther, own_before, own_after)}; {why}"
            ]
        return [
            "the fit does not bring the model nearer to these recordings: the error of the "
            f"{_both(farther, own_before, own_after)}; {why}. Keep the model as it was"
        ]
    if (farther := _grew(before, after)) and sum(_growths(before, after).values()) > 0.0:
        told = _both(farther, before, after)
        return [f"on what was not fitted to, the model as it was is nearer: the error of the {told}"]
    return []


def still_far(after: Errors, hit: bool) -> list[str]:
    """A note if an error is still many times the sensors' noise; ``hit``: whether teeth meet in the model."""
    told = {signal: error for signal, error in after.items() if tells(signal, error, after)}
    worst = max(told, key=lambda s: times_noise(told[s]), default=None)
    if worst is None or not told[worst]["rmse"] > TOO_MUCH * told[worst]["noise_floor"] > 0.0:
        return []
    times = times_words(times_noise(told[worst]))
    advice = "compare tells what it depends on, diagnose whether an effect is missing"
    if hit:
        advice = f"impact timing off by 1 ms can cause this; {advice}"
    return [f"what is left of the {signal_words(worst, told[worst]['unit'])} is {times} the sensors' noise: {advice}"]


def tells(signal: str, error: SignalError, errors: Errors) -> bool:
    """Whether a signal's error says something about the model: it is no input and does not drift."""
    by_current = any(errors[name]["driven"] for name in ("current", "motor_torque") if name in errors)
    return not error["driven"] and not (by_current and signal in drifting("current"))


def _is_nearer(before: SignalError, after: SignalError) -> bool:
    """Whether an error above the noise shrank; near the noise too, as ``compare`` counts what is above it."""
    return not is_noise(before) and after["rmse"] < (1.0 - NEGLIGIBLE) * before["rmse"]


def _grew(before: Errors, after: Errors) -> list[str]:
    """The signals whose errors grew beyond the noise."""
    return [signal for signal, growth in _growths(before, after).items() if growth > math.log1p(NEGLIGIBLE)]


def _growths(before: Errors, after: Errors) -> dict[str, float]:
    """Logarithm by which each error grew that says something, so that each counts in units of its own.

    Errors within the noise count as the noise.
    """

    def above(error: SignalError) -> float:
        return max(error["rmse"], NOISY * error["noise_floor"], sys.float_info.min)

    return {
        signal: math.log(above(error) / above(before[signal]))
        for signal, error in after.items()
        if tells(signal, error, after)
    }


def _both(signals: Sequence[str], before: Errors, after: Errors, way: str = "grows") -> str:
    """These signals, with both errors."""
    return ", that of the ".join(
        f"{signal_words(signal, after[signal]['unit'])} {way} "
        f"from {quantity(before[signal]['rmse'], after[signal]['unit'])} to "
        f"{quantity(after[signal]['rmse'], after[signal]['unit'])}"
        for signal in signals
    )
