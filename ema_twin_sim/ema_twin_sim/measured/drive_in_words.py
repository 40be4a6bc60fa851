"""The signal that tells a drive's torque, and its values, as a person gave them."""

from __future__ import annotations

from ema_bench_replay.recording import Recording

from ..model import Model
from ..model.matching import BY_TORQUE
from ..model.own_units import shown
from ..quantities import quantity


def drive_in_words(recording: Recording, model: Model, *currents: float) -> tuple[str, ...]:
    """The name of the signal that tells the drive's torque, and these currents [own A] in its unit."""
    if BY_TORQUE not in recording.metadata:
        return "current", *(quantity(*shown(model, current, "A")) for current in currents)
    constant = model.value("machine.torque_constant")
    return "motor_torque", *(quantity(*shown(model, constant * current, "N m")) for current in currents)
