"""Check whether the DC link of a switching drive allows the recorded or commanded speed."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import pieces, quantile, slopes
from ema_bench_replay.recording import Recording

from ..model import Model
from ..plant.switching.dc_link import highest_speed, voltage_needed
from .assembly import Assembly, assemble
from .command import Command

_HELD = 0.999
"""Quantile of a recording's speed that is checked: single wrong samples do not count."""


def holding_current(assembly: Assembly, speed: float) -> float:
    """Current [A] needed for a plant's friction at a steady speed [rad/s], without operating-point effects."""
    plant = assembly.plant[0]
    viscous, dry = (plant[f"motor_{kind}"] + plant[f"output_{kind}"] for kind in ("viscous", "dry"))
    return float((dry + viscous * abs(speed)) / plant["torque_constant"])


def allowed_speed(assembly: Assembly) -> float:
    """Highest speed [rad/s] at which the DC link can drive the friction; infinite if the drive does not switch."""
    if not assembly.fine.switching:
        return np.inf
    winding = assembly.fine.winding[0]
    speed = highest_speed(winding, 0.0)
    for _ in range(50):  # friction grows with speed, which lowers the highest speed
        speed = 0.5 * (speed + highest_speed(winding, holding_current(assembly, speed)))
    return speed


def refuse_beyond_link(model: Model, speed: float, place: str) -> None:
    """Raise InputError if a motor speed [rad/s] exceeds what the model's DC link allows."""
    if model.kinds["drive"] != "switching":
        return
    assembly = assemble(model)
    allowed = allowed_speed(assembly)
    if speed <= allowed:
        return
    link = model.value("drive.dc_link_voltage")
    needed = voltage_needed(assembly.fine.winding[0], speed, holding_current(assembly, speed))
    raise InputError(
        f"{place} turns the motor at {speed:.4g} rad/s, but the DC link of {link:.4g} V of model {model.name} allows "
        f"{allowed:.4g} rad/s; give drive.dc_link_voltage {math.ceil(needed)} V or more, or less speed"
    )


def refuse_recording_beyond_link(model: Model, recording: Recording, source: str) -> None:
    """The same for a recording's motor speed; with the input ``current`` no bridge drives the twin."""
    if source == "current" or model.kinds["drive"] != "switching":
        return
    if recording.has("speed"):
        speed = recording.signals["speed"]
    elif recording.has("motor_position"):
        speed = slopes(recording.signals["motor_position"], recording.time)
    else:
        speed = recording.signals.get("speed_setpoint", np.zeros(1))

    def sizes() -> Iterator[np.ndarray]:
        for rows in pieces(len(speed)):
            yield np.abs(speed[rows][~np.isnan(speed[rows])])

    refuse_beyond_link(model, quantile(sizes, _HELD), recording.name)


def refuse_command_beyond_link(model: Model, command: Command, time: np.ndarray) -> None:
    """The same for the commanded speed at these times [s] (n,), within the drive's speed limit."""
    asked = command.highest_speed(time) * model.value("machine.gear_ratio")
    refuse_beyond_link(model, min(asked, model.value("drive.speed_limit")), f"command '{command.text}'")
