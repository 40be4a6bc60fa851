"""The rotary machine that a linear one is equivalent to: its carriage runs round a drum.

What a search knows beforehand (at which speeds a motor stands still, how large an effect usually is) is known of
rotary machines. So a linear machine is searched as the rotary one with a drum of some radius, x = r θ, F = T / r, and
what was found is given back as the linear machine has it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ema_bench_replay.recording import MOTION, Recording
from ema_bench_replay.units import signal_unit, unit_in

from ..effects import find_effect
from .constants import CONSTANTS
from .matching import matched
from .model import Model

USUAL_SPEED = 10.0  # rad/s, of the drum
FASTEST = 0.95  # quantile of the speeds

_POWERS = {
    "rad": 1,
    "rad/s": 1,
    "rad/s^2": 1,
    "N m": -1,
    "N m/A": -1,
    "V s/rad": -1,
    "N m s/rad": -2,
    "N m/rad": -2,
    "kg m^2": -2,
    "N m s^2/rad^2": -3,
    "1/rev": -1,
}
"""By rotary unit, the power of the radius that leads from the drum's number to the carriage's."""


def drum_radius(recordings: Sequence[Recording], model: Model) -> float:
    """Radius [m] of a drum that turns at usual speeds, a power of ten; 1 where the machine is rotary."""
    if model.motion == "rotary":
        return 1.0
    speeds = [_speed(recording) for recording in recordings]
    known = np.concatenate(speeds)
    fastest = float(np.quantile(known, FASTEST)) if len(known) else 0.0
    return 10.0 ** round(math.log10(fastest / USUAL_SPEED)) if fastest > 0.0 else 1.0


def _speed(recording: Recording) -> np.ndarray:
    """Sizes (m,) of the speed [m/s]: measured, or of the motor's position where samples follow each other in time."""
    if recording.has("speed"):
        speed = np.abs(recording.signals["speed"])
    elif recording.has("motor_position") and not recording.of_points:
        speed = np.abs(np.diff(recording.signals["motor_position"]) / np.diff(recording.time))
    else:
        speed = np.zeros(0)
    return speed[np.isfinite(speed)]


def factor(unit: str, radius: float) -> float:
    """What the drum's number in a rotary unit is multiplied by to be the carriage's."""
    turn = 2.0 * math.pi if unit == "1/rev" else 1.0
    return radius ** _POWERS.get(unit, 0) / turn


def as_rotary(recordings: Sequence[Recording], model: Model) -> tuple[list[Recording], Model]:
    """Recordings and model as a search takes them: matched, and of the drum where the machine is linear.

    Raises InputError where they do not belong together.
    """
    found = [matched(recording, model) for recording in recordings]
    radius = drum_radius(found, model)
    return [round_the_drum(recording, radius) for recording in found], rotary(model, radius)


def rotary(model: Model, radius: float) -> Model:
    """The drum's model; it remembers the radius."""
    return replace(_scaled(model, radius, -1), motion="rotary", radius=radius) if model.motion == "linear" else model


def given_back(model: Model) -> Model:
    """A drum's model as that of its carriage; another model as it is."""
    if model.radius is None:
        return model
    return replace(_scaled(model, model.radius, 1), motion="linear", radius=None)


def round_the_drum(recording: Recording, radius: float) -> Recording:
    """The recording with angles, speeds and torques of the drum; ``radius`` 1 leaves it as it is."""
    if radius == 1.0:
        return recording
    per = {name: factor(signal_unit(name), radius) for name in recording.signals}
    return replace(
        recording,
        signals={name: values / per[name] for name, values in recording.signals.items()},
        motor_angle_origin=recording.motor_angle_origin / radius,
        output_angle_origin=recording.output_angle_origin / radius,
        metadata={**recording.metadata, MOTION: "rotary"},
    )


def shown(model: Model, value: float, unit: str) -> tuple[float, str]:
    """A number of a model in a rotary unit, and that unit, as people know them: a drum's as its carriage's."""
    if model.radius is None:
        return value, unit_in(unit, model.motion)
    return value * factor(unit, model.radius), unit_in(unit, "linear")


def shown_entry(model: Model, value: float, std: float | None, unit: str, *, angle: bool = False) -> dict[str, Any]:
    """``{value, std, unit}`` as people know them; ``unit`` is the rotary one, of an ``angle`` that of any machine."""
    if angle:
        return {"value": value, "std": std, "unit": unit}
    own, written = shown(model, value, unit)
    return {"value": own, "std": None if std is None else shown(model, std, unit)[0], "unit": written}


def _scaled(model: Model, radius: float, sign: int) -> Model:
    constants = {
        path: replace(held, value=held.value * factor(CONSTANTS[path].unit, radius) ** sign)
        for path, held in model.constants.items()
    }
    effects = {}
    for name, instance in model.effects.items():
        rows = find_effect(instance.effect, name).parameters
        units = {p.name: "1" if p.periodic else p.unit for p in rows}
        parameters = {k: v * factor(units[k], radius) ** sign for k, v in instance.parameters.items()}
        effects[name] = replace(instance, parameters=parameters)
    return replace(model, constants=constants, effects=effects)
