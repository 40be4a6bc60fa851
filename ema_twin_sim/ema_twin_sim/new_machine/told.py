"""What a drafted model rests on, in words: what the recording showed, what was given, and what is only assumed."""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Model
from ..model.model_file import ABSENT
from ..quantities import quantity
from .model_draft import AS_FINE_AS_NOISE

_TOLD = {
    "machine.gear_ratio": "gear ratio",
    "machine.torque_constant": "torque constant",
    "drive.speed_gain": "speed controller's gain",
    "drive.integral_time": "its integral time",
    "sensors.motor_encoder_counts": "motor encoder",
    "sensors.output_encoder_counts": "output encoder",
    "sensors.current_noise": "noise of the current",
    "sensors.speed_noise": "noise of the speed",
}
ASSUMED = "assumed"
_HOW = {
    "machine.gear_ratio": "give --gear-ratio",
    "machine.torque_constant": "torques are told in amperes' worth; give --torque-constant from the data sheet",
}


def shown(model: Model) -> list[str]:
    """What a recording showed, or a person gave: each ``name value unit``."""
    return [f"{name} {value}" for path, name, value in _values(model) if model.constants[path].source != ASSUMED]


def assumed(model: Model) -> list[str]:
    """What is only assumed, and what to do about it."""
    return [
        f"{name} {value} ({_HOW[path]})"
        for path, name, value in _values(model)
        if model.constants[path].source == ASSUMED
    ]


def _values(model: Model) -> Iterator[tuple[str, str, str]]:
    """(path, name, value with unit) of what a draft may have found."""
    for path, name in _TOLD.items():
        held = model.constants[path]
        if held.source not in ("", ABSENT, AS_FINE_AS_NOISE):  # a position that comes in no steps shows no counts
            unit = model.unit(path)
            if unit == "1/rev":
                yield path, name, f"{held.value:.0f} counts a turn"
            else:
                yield path, name, f"{held.value:.4g}" if unit == "1" else quantity(held.value, unit)
