"""Matching: convert a recording so that a model's twin can use it, whatever its signals and shafts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import Column, by_pieces, divided, extremes, overlapping, pieces, times
from ema_bench_replay.recording import AT, AT_EITHER_SHAFT, KIND, MAGNITUDE, MAY_BE_MAGNITUDES, Recording

from .model import Model

BY_TORQUE = "driven_by"
"""Metadata of a recording with the drive's torque instead of a current: ``{BY_TORQUE: "torque"}``."""
BY_SPEED = "position_by"
"""Metadata of a recording with the motor's speed instead of its position: ``{BY_SPEED: "speed"}``."""
WITHOUT_SIGN = "without_sign"
"""Metadata of a recording that has lost magnitudes: ``{WITHOUT_SIGN: "current and motor_torque"}``."""
_STILL = 100.0  # an output at rest travels less than 1 / this of what a rigid train would give
_IMPOSSIBLE = 10.0  # times the drive's limit: a corrupt sample rather than a wrong unit


def matched(recording: Recording, model: Model) -> Recording:
    """The recording with all motor signals at the fast shaft; a missing current is computed from the torque, a missing
    position from the speed.

    Raises InputError if recording and model differ in motion (rotary, linear), or a speed is beyond the drive's.
    """
    if recording.motion != model.motion:
        raise InputError(
            f"{recording.name}: is of a {recording.motion} machine, model {model.name} of a {model.motion} one; "
            "name the right import map (--map) or model (--model)"
        )
    signals: dict[str, np.ndarray] = dict(recording.signals)
    origin = recording.motor_angle_origin
    metadata = dict(recording.metadata)
    warnings, unsigned = [*recording.warnings], []
    for name in MAY_BE_MAGNITUDES:
        if metadata.pop(f"{name}{KIND}", None) == MAGNITUDE and signals.pop(name, None) is not None:
            unsigned.append(name)
            warnings.append(
                f"{recording.name}: the {name.replace('_', ' ')} is a magnitude, which does not tell which way it "
                "acts: left out"
            )
    if unsigned:
        metadata[WITHOUT_SIGN] = " and ".join(unsigned)
    for name in AT_EITHER_SHAFT:
        if metadata.pop(f"{name}{AT}", None) is not None and name in signals:
            ratio = model.value("machine.gear_ratio")
            signals[name] = divided(signals[name], ratio) if name.endswith("torque") else times(signals[name], ratio)
            origin *= ratio if name == "motor_position" else 1.0
    _refuse_impossible_speeds(recording, signals, model)
    if "current" not in signals and "motor_torque" in signals:
        signals["current"] = divided(signals["motor_torque"], model.value("machine.torque_constant"))
        metadata[BY_TORQUE] = "torque"
    if not {"motor_position", "output_position"} & signals.keys() and "speed" in signals and not recording.of_points:
        signals["motor_position"] = way_of(signals["speed"], recording.time)
        metadata[BY_SPEED] = "speed"
        warnings.append(
            f"{recording.name}: has no position; its speed is integrated instead, and angles count from its start"
        )
    if clamped := _clamped(signals, model):
        del signals["output_position"]
        warnings.append(f"{recording.name}: {clamped}")
    if signals.keys() == recording.signals.keys() and metadata == recording.metadata:
        return recording
    return replace(recording, signals=signals, motor_angle_origin=origin, metadata=metadata, warnings=tuple(warnings))


def by_torque(recordings: Sequence[Recording]) -> bool:
    """Whether no matched recording has a current: then the drive is told by its torque."""
    return all(BY_TORQUE in recording.metadata for recording in recordings)


def way_of(speed: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Integral (n,) of a speed; missing values are interpolated linearly. NaN if it is never known."""
    known = by_pieces(np.isfinite, speed)
    if not known.any():
        return by_pieces(partial(np.full_like, fill_value=np.nan), speed)
    if not known.all():
        speed = np.interp(time, time[known], speed[known])
    way = Column(np.float64)
    way.add(np.zeros(1))
    came = 0.0
    for speeds, at in zip(overlapping(speed), overlapping(time), strict=True):
        went = came + np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * np.diff(at))
        way.add(went)
        came = float(went[-1]) if len(went) else came
    return way.finish()


def _clamped(signals: Mapping[str, np.ndarray], model: Model) -> str:
    """A note if the output stands still while the motor turns; empty if it moves.

    In a torsion test it is clamped: the compliance in between is then a spring that the motor winds up.
    """
    if not {"motor_position", "output_position", "current"} <= signals.keys():
        return ""
    motor, output = (signals[f"{side}_position"] for side in ("motor", "output"))
    travel, moved = (greatest - least for least, greatest in map(extremes, (motor, output)))
    if math.isnan(travel) or math.isnan(moved):
        return ""
    unit = model.unit("drive.speed_limit").partition("/")[0]
    expected = travel / model.value("machine.gear_ratio")
    counts = model.value("sensors.output_encoder_counts")
    seen = max(moved, model.turn / counts if counts > 0.0 else 0.0)
    if not expected > _STILL * seen:
        return ""
    return (
        f"the output stands still while the motor turns by {travel:.3g} {unit}: its position is left out. If it is "
        "clamped, what gives way shows as spring_load at the motor; if it is not, check its encoder"
    )


def _refuse_impossible_speeds(recording: Recording, signals: Mapping[str, np.ndarray], model: Model) -> None:
    limit, unit = model.value("drive.speed_limit"), model.unit("drive.speed_limit")
    for name in ("speed_setpoint", "speed"):
        fastest, worst = 0.0, 0
        speed = signals.get(name, np.zeros(1))
        for rows in pieces(len(speed)):
            sizes = np.abs(speed[rows])
            at = int(np.argmax(np.where(np.isfinite(sizes), sizes, 0.0)))
            if sizes[at] > fastest:
                fastest, worst = float(sizes[at]), rows.start + at
        if fastest > _IMPOSSIBLE * limit:
            place = f"at {recording.time[worst]:.3f} s (sample {worst})"
            raise InputError(
                f"{recording.name}: {name} is {fastest:.4g} {unit} {place}, "
                f"and drive.speed_limit of model {model.name} is {limit:.4g} {unit}; correct the sample, or cut it off "
                "(--from, --to)"
            )
