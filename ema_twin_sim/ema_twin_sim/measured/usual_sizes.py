"""Values unusual for drives, which suggest a wrong unit.

If no constant of a machine is known, its mechanics do not distinguish milliamperes from amperes: inertia and friction
would all be a thousand times as large. So unusual values lead to a question; they decide nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..model import Model
from ..model.matching import BY_TORQUE
from ..model.model_file import ABSENT

USUAL: dict[str, tuple[float, float, str, str]] = {
    "current": (0.02, 100.0, "A", "mA"),
    "speed": (0.0, 2500.0, "rad/s", "rpm"),
}
"""By signal: usual lower and upper limit of its largest value, its unit, and the unit it is mistaken for."""


def unusual_sizes(recording: Recording) -> Iterator[str]:
    """Questions about the units of a rotary machine's recording, from its largest current and speed."""
    if recording.motion != "rotary":
        return
    for signal, (least, most, unit, other) in USUAL.items():
        if not recording.has(signal):
            continue
        largest = _largest(recording, signal)
        if largest > most:
            yield (
                f"{recording.name}: {signal} reaches {largest:.4g} {unit}, more than most drives ever do: is its "
                f"column in {other}, and read as {unit}?"
            )
        elif 0.0 < largest < least:
            yield (
                f"{recording.name}: {signal} reaches {largest:.3g} {unit} only: is its column in {unit}, and read as "
                f"{other}?"
            )


def unusual_currents(recordings: Sequence[Recording], model: Model) -> tuple[str, ...]:
    """The question about the current, for the recording with the largest one, if the model does not answer it.

    A model answers it if its constants are known, or if it has a limit of its drive's current.
    """
    with_current = [r for r in recordings if r.has("current") and BY_TORQUE not in r.metadata]
    if not with_current or not model.is_open or model.constants["drive.current_limit"].source != ABSENT:
        return ()
    most = max(with_current, key=lambda recording: _largest(recording, "current"))
    return tuple(
        f"{question} If not, write drive.current_limit into the model"
        for question in unusual_sizes(most)
        if question.startswith(f"{most.name}: current ")
    )


def _largest(recording: Recording, signal: str) -> float:
    return float(np.nanmax(np.abs(recording.signals[signal])))
