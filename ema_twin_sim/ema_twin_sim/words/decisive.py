"""A sentence on an error that a short stretch of a recording decides, and on how to leave that stretch out."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..comparison.beyond_noise import beyond_noise
from ..comparison.compare import Comparison
from ..comparison.decisive_stretch import DecisiveStretch
from ..quantities import signal_words

_ROUNDED = 1e-3  # s, to which times are told


def decisive_sentence(comparison: Comparison, start: float = 0.0) -> str:
    """A sentence on the worst signal whose error over all recordings is decided by short stretches; empty without one.

    ``start`` [s] is where the recordings were cut: the times that are told, and ``--from``, count from before it.
    """
    for signal in beyond_noise(comparison.input, comparison.overall):
        of = {r.name: r.stretches[signal] for r in comparison.recordings if signal in r.stretches}
        squares = {
            r.name: r.samples * r.signals[signal]["rmse"] ** 2 for r in comparison.recordings if signal in r.signals
        }
        held = {name: stretch.of_squares * squares[name] for name, stretch in of.items()}
        if sum(held.values()) > 0.5 * sum(squares.values()):
            name = max(held, key=lambda name: held[name])
            samples, power = 100.0 * of[name].of_samples, 100.0 * of[name].of_squares
            words = signal_words(signal, comparison.overall[signal]["unit"])
            others = f" (likewise in {len(of) - 1} more)" if len(of) > 1 else ""
            return (
                f"{name}: {_span(of[name], start)} ({samples:.3g} % of its samples) hold {power:.0f} % of the squared "
                f"error of the {words}{others}, so its RMSE says little about the rest. "
                f"{_remedy(comparison, of, start)}"
            )
    return ""


def _remedy(comparison: Comparison, of: Mapping[str, DecisiveStretch], start: float) -> str:
    """How the stretches are left out: by beginning after them, by ending before them, or only by a look at both."""
    duration = {recording.name: recording.duration for recording in comparison.recordings}
    if all(stretch.begin <= stretch.end - stretch.begin for stretch in of.values()):
        after = _up(start + max(stretch.end for stretch in of.values()))
        return (
            f"To leave it out, begin after it (--from {after}), best where the machine stands still or moves steadily: "
            "a twin does not know what was before its start"
        )
    if all(duration[name] - stretch.end <= stretch.end - stretch.begin for name, stretch in of.items()):
        return f"To leave it out, end before it: --to {_down(start + min(stretch.begin for stretch in of.values()))}"
    return "To judge the rest: --to for what is before it, --from for what is after it"


def _span(stretch: DecisiveStretch, start: float) -> str:
    return f"{_down(start + stretch.begin)} to {_up(start + stretch.end)} s"


def _up(time: float) -> str:
    return _written(_ROUNDED * math.ceil(time / _ROUNDED - _ROUNDED))


def _down(time: float) -> str:
    return _written(_ROUNDED * math.floor(time / _ROUNDED + _ROUNDED))


def _written(time: float) -> str:
    return f"{time:.3f}".rstrip("0").rstrip(".")
