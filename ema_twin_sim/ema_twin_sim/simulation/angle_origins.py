"""Zero of angles: the counters' own, so that a phase found on one recording holds on the next."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from ema_bench_replay.recording import Recording

from ..effects import catalogue
from ..model import EffectInstance, Model
from ..plant.layout import OUTPUT_TORQUE


def angle_origins(motor: float, output: float, ratio: float) -> tuple[float, float]:
    """(motor, output) [rad]: the angles of a machine with this gear ratio at position zero.

    Without an output encoder, or if its own angle is unknown, the output angle follows from the motor's counter. An
    angle that nothing determines counts from the recording's first sample.
    """
    motor_at = 0.0 if math.isnan(motor) else motor
    return motor_at, motor_at / ratio if math.isnan(output) else output


def origins_of(recording: Recording, model: Model) -> tuple[float, float]:
    """The same for a recording."""
    ratio = model.value("machine.gear_ratio")
    return angle_origins(recording.motor_angle_origin, recording.output_angle_origin, ratio)


def without_common_zero(recordings: Sequence[Recording], effects: Iterable[EffectInstance]) -> tuple[str, ...]:
    """One warning if effects act at an angle that some recordings do not contain; otherwise none."""
    found: dict[str, list[str]] = {}
    for instance in effects:
        effect = catalogue()[instance.effect]
        if not acts_at_an_angle(instance):
            continue
        of_output = effect.where(instance.options) == OUTPUT_TORQUE or effect.depends_on in _OF_THE_OUTPUT
        blind = [
            r.name
            for r in recordings
            if math.isnan(r.motor_angle_origin) and not (of_output and math.isfinite(r.output_angle_origin))
        ]
        if blind:
            found[instance.effect] = blind
    if not found:
        return ()
    names = sorted({name for blind in found.values() for name in blind})
    shown = ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
    which = " and ".join(found)
    return (
        f"{shown}: the counter's own angle is not known, so the phase of {which} counts from each recording's first "
        "sample, and holds where the machine starts from the same place; import positions as the encoder shows them",
    )


_OF_THE_OUTPUT = ("output_position", "encoders")
_NAMED = 3


def acts_at_an_angle(instance: EffectInstance) -> bool:
    """Whether what an effect does depends on the angle itself, and so on its zero."""
    effect = catalogue()[instance.effect]
    placed = any(p.periodic or p.is_place for p in effect.parameters_with(instance.options))
    return effect.depends_on == "order" or placed
