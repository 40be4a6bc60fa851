"""Matching: a recording as a model's twin can take it, whatever signals and units its machine came with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import AT_OUTPUT, Recording

from .model import Model

BY_TORQUE = "driven_by"
"""The metadata of a recording that has no current but its drive's torque: ``{BY_TORQUE: "torque"}``."""
_IMPOSSIBLE = 10.0  # times the drive's limit: no unit that was mistaken, but a sample that is spoilt


def matched(recording: Recording, model: Model) -> Recording:
    """The recording with the motor's position at the fast shaft, and a current where it has but the drive's torque.

    Raises InputError where recording and model are of different motions (rotary, linear), or a speed is one that the
    drive never gives.
    """
    if recording.motion != model.motion:
        raise InputError(
            f"{recording.name}: is of a {recording.motion} machine, model {model.name} of a {model.motion} one; "
            "name the right import map (--map) or model (--model)"
        )
    _refuse_impossible_speeds(recording, model)
    signals: dict[str, np.ndarray] = dict(recording.signals)
    origin = recording.motor_angle_origin
    metadata = dict(recording.metadata)
    if metadata.pop(AT_OUTPUT, None) is not None and "motor_position" in signals:
        ratio = model.value("machine.gear_ratio")
        signals["motor_position"] = signals["motor_position"] * ratio
        origin *= ratio
    if "current" not in signals and "motor_torque" in signals:
        signals["current"] = signals["motor_torque"] / model.value("machine.torque_constant")
        metadata[BY_TORQUE] = "torque"
    if len(signals) == len(recording.signals) and metadata == recording.metadata:
        return recording
    return replace(recording, signals=signals, motor_angle_origin=origin, metadata=metadata)


def _refuse_impossible_speeds(recording: Recording, model: Model) -> None:
    limit, unit = model.value("drive.speed_limit"), model.unit("drive.speed_limit")
    for name in ("speed_setpoint", "speed"):
        values = np.abs(recording.signals.get(name, np.zeros(1)))
        worst = int(np.argmax(np.where(np.isfinite(values), values, 0.0)))
        if values[worst] > _IMPOSSIBLE * limit:
            place = f"at {recording.time[worst]:.3f} s (sample {worst})"
            raise InputError(
                f"{recording.name}: {name} is {values[worst]:.4g} {unit} {place}, "
                f"and drive.speed_limit of model {model.name} is {limit:.4g} {unit}; correct the sample, or cut it off "
                "(--from, --to)"
            )
