"""Values unusual for drives, which suggest a wrong unit.

If no constant of a machine is known, its mechanics do not distinguish milliamperes from amperes: inertia and friction
would all be a thousand times as large. So unusual values lead to a question; they decide nothing.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..model import Model
from ..model.matching import BY_TORQUE
from ..model.model_file import ABSENT, TORQUE_CONSTANT

USUAL: dict[str, tuple[float, float, str, str]] = {
    "current": (0.02, 100.0, "A", "mA"),
    "speed": (0.0, 2500.0, "rad/s", "rpm"),
    "motor_torque": (0.0, 1e4, "N m", "mN m"),
    "load_torque": (0.0, 1e4, "N m", "mN m"),
}
"""By signal: usual lower and upper limit of its largest value, its unit, and the unit it is mistaken for."""
_THEN = (
    "Then correct the unit in the column's name, and run init again: a drafted model has its noise in that unit, too."
)
WINDING: dict[str, float] = {"usual": 4.0, "mistaken": 1000.0}
"""Induced voltage over current [ohm] in the middle of what drives have, from 0.1 (12 V, 100 A) to 150 (1.5 V, 10 mA);
and the factor of a wrong unit."""


def unusual_sizes(recording: Recording, besides: Collection[str] = ()) -> Iterator[str]:
    """Questions about the units of a rotary machine's recording, from its largest current and speed.

    Signals in ``besides`` are not asked about: their units are known to be others.
    """
    if recording.motion != "rotary":
        return
    for signal, (least, most, unit, other) in USUAL.items():
        if not recording.has(signal) or signal in besides:
            continue
        largest = largest_of(recording, signal)
        if largest > most:
            yield (
                f"{recording.name}: {signal} reaches {largest:.4g} {unit}, more than most drives ever do: is its "
                f"column in {other}, and read as {unit}? {_THEN}"
            )
        elif 0.0 < largest < least:
            yield (
                f"{recording.name}: {signal} reaches {largest:.3g} {unit} only: is its column in {unit}, and read as "
                f"{other}? {_THEN}"
            )


def unusual_currents(recordings: Sequence[Recording], model: Model) -> tuple[str, ...]:
    """The question about the current, for the recording with the largest one, if the model does not answer it.

    A model answers it if its constants are known, if it has a limit of its drive's current, or if its torque constant
    was given and suits such a current.
    """
    with_current = [r for r in recordings if r.has("current") and BY_TORQUE not in r.metadata]
    if not with_current or not model.is_open or model.constants["drive.current_limit"].source != ABSENT:
        return ()
    most = max(with_current, key=lambda recording: largest_of(recording, "current"))
    if _suits_torque_constant(with_current, model):
        return ()
    limit = float(f"{10.0 * largest_of(most, 'current'):.1g}")
    return tuple(
        f"{question} If the unit is right, write the limit of the drive's current into the model, under `drive:`, with "
        f"the drive's own number: `current_limit: {{value: {limit:.15g}, unit: A, source: given}}`"
        for question in unusual_sizes(most)
        if question.startswith(f"{most.name}: current ")
    )


def _suits_torque_constant(recordings: Sequence[Recording], model: Model) -> bool:
    """Whether the current as it was read suits the given torque constant better than one read in the other unit.

    A torque constant in N m/A is one in V s/rad, so the voltage that the motor induced at its largest speed is known.
    Over the largest current it has the size of a winding's resistance, which is that of usual drives (``WINDING``) or
    a thousand times as large or small, even where the current alone is unusual: a watch's motor induces 1 V and takes
    10 mA. Without a torque constant or a speed this is not known.
    """
    given = model.constants[TORQUE_CONSTANT]
    fast = [largest_of(recording, "speed") for recording in recordings if recording.has("speed")]
    current = max(largest_of(recording, "current") for recording in recordings)
    if given.source == ABSENT or not fast or not min(given.value, max(fast), current) > 0.0:
        return False
    return abs(_beside_usual_windings(given.value, max(fast), current)) < 0.5


def looks_too_small_for_a_winding(constant: float, speed: float, current: float) -> bool:
    """Whether a motor of that constant [V s/rad, V s/m] induces too little at ``speed`` for one that takes ``current``.

    False where one of them is zero.
    """
    return min(constant, speed, current) > 0.0 and _beside_usual_windings(constant, speed, current) < -0.5


def _beside_usual_windings(constant: float, speed: float, current: float) -> float:
    """How far induced voltage over current is from that of usual drives, in powers of a unit's mistake."""
    return math.log(constant * speed / current / WINDING["usual"]) / math.log(WINDING["mistaken"])


def largest_of(recording: Recording, signal: str) -> float:
    """The largest magnitude of a signal."""
    return float(np.nanmax(np.abs(recording.signals[signal])))
