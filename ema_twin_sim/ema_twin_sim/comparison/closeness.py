"""How many times closer one model is than another, above the sensors' noise."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..criteria import LIKELY
from .running_comparison import SignalError

if TYPE_CHECKING:
    from .compare import Comparison

AT_LEAST, EXACTLY, AT_MOST = "at_least", "", "at_most"


@dataclass(frozen=True)
class Closeness:
    """The excess of one model over that of another; ``bound`` is set if the smaller excess is lost in the noise."""

    times: float
    bound: str = EXACTLY

    def as_json(self) -> dict[str, object]:
        """``{"times"}``, and ``bound`` if the number is only a bound."""
        return {"times": self.times, **({"bound": self.bound} if self.bound else {})}


def times_closer(before: SignalError, after: SignalError, independent: float) -> Closeness | None:
    """Ratio of the excesses, roots of RMSE^2 - noise floor^2; None if neither model has one.

    The mean square of this many ``independent`` values of noise scatters by root(2/independent) of itself. An excess
    below two of these is replaced by that limit, and the ratio is then a bound.
    """
    floor = after["noise_floor"]
    least = floor**2 * LIKELY * math.sqrt(2.0 / independent)
    first, other = (max(error["rmse"] ** 2 - floor**2, 0.0) for error in (before, after))
    if max(first, other) <= least:
        return None
    if other <= least:
        return Closeness(math.sqrt(first / least), AT_LEAST) if least else None
    if first <= least:
        return Closeness(math.sqrt(least / other), AT_MOST)
    return Closeness(math.sqrt(first / other))


@dataclass(frozen=True)
class CloserModel:
    """A model compared with the first: how many times closer it is in each signal, per recording and overall."""

    than: str
    recordings: tuple[tuple[str, Mapping[str, Closeness]], ...]
    overall: Mapping[str, Closeness]

    def as_json(self) -> dict[str, object]:
        """For ``compare --json``; signals in which neither model exceeds the noise are left out."""
        return {
            "than": self.than,
            "recordings": [{"name": name, "signals": _as_json(signals)} for name, signals in self.recordings],
            "overall": _as_json(self.overall),
        }


def closer(first: Comparison, other: Comparison) -> CloserModel:
    """How many times closer ``other`` is than ``first``; both were compared with the same recordings."""
    pairs = zip(first.recordings, other.recordings, strict=True)
    return CloserModel(
        first.model,
        tuple(
            (before.name, _of_signals((before.signals, before.independent), (after.signals, after.independent)))
            for before, after in pairs
        ),
        _of_signals((first.overall, first.independent), (other.overall, other.independent)),
    )


def _of_signals(
    before: tuple[Mapping[str, SignalError], Mapping[str, float]],
    after: tuple[Mapping[str, SignalError], Mapping[str, float]],
) -> dict[str, Closeness]:
    """By signal, from the errors of both models and their numbers of independent values."""
    found = {}
    for name in before[0]:
        if name in after[0] and not before[0][name]["driven"]:
            # the residual closer to the noise determines its scatter; the drive's torque uses the current's
            _, rows = min(before, after, key=lambda side: side[0][name]["rmse"])
            of = "current" if name == "motor_torque" else name
            found[name] = times_closer(before[0][name], after[0][name], rows[of])
    return {name: closeness for name, closeness in found.items() if closeness is not None}


def _as_json(signals: Mapping[str, Closeness]) -> dict[str, object]:
    return {name: closeness.as_json() for name, closeness in signals.items()}
