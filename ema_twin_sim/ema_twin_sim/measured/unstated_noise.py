"""Noise of the sensors from the recordings, for a model that states none.

A model without ``sensors`` has perfect ones: any error would exceed their noise of zero, and effects would be looked
for in noise. An acceleration that comes late by the drive's smoothing of its speed is such an error as well. The draft
of a new machine gets both in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ema_bench_replay.recording import Recording, spread

from ..criteria import CLEARLY_MORE
from ..model import Model
from ..model.constants import CONSTANTS
from ..model.matching import BY_TORQUE, matched
from ..model.model import ConstantValue
from ..model.model_file import ABSENT
from ..quantities import quantity
from ..reading_noise import noise_of_points, polled_noise
from .speed_lag import speed_lag

SMOOTHING = "sensors.speed_smoothing"
OUTPUT_COUNTS, OUTPUT_NOISE = "sensors.output_encoder_counts", "sensors.output_encoder_noise"
_SOURCE = "third differences of the recordings"
_LAG_SOURCE = "lag of the speed behind the position"


def with_noise_of(recordings: Sequence[Recording], model: Model) -> tuple[Model, str]:
    """The model with the noise of the recordings, and a sentence on it; unchanged if the model states its current's.

    Each sensor without a constant in the model's file gets one: current and speed their white noise, an encoder steps
    that make as much noise as its position has, a speed the smoothing by which it lags the position. Raises InputError
    if recordings and model do not belong together.
    """
    if model.constants["sensors.current_noise"].source != ABSENT:
        return model, ""
    found = [matched(part, model) for part in spread(recordings)]
    constants, told = dict(model.constants), []
    for name in ("current", "speed", "motor_position", "output_position"):
        side = name.removesuffix("_position")
        path = f"sensors.{name}_noise" if side == name else f"sensors.{side}_encoder_counts"
        noise = _noise(found, name)
        if constants[path].source != ABSENT or not noise > 0.0:
            continue
        value, unit = noise, CONSTANTS[path].unit
        if side != name:
            value, unit = model.turn / (math.sqrt(12.0) * noise), "rad"
        if not CONSTANTS[path].lower <= value <= CONSTANTS[path].upper:
            continue
        constants[path] = ConstantValue(value, 0.0 if side != name else 0.05, _SOURCE)
        said, signal = noise, name.replace("_", " ")
        if name == "current" and any(BY_TORQUE in recording.metadata for recording in found):
            said, unit, signal = noise * model.value("machine.torque_constant"), "N m", "torque"
        if model.motion == "linear":
            unit, signal = unit.replace("N m", "N").replace("rad", "m"), signal.replace("torque", "force")
        told.append(f"{signal} {quantity(said, unit)}")
    if (read := _beyond_counts(found, model)) is not None:
        constants[OUTPUT_NOISE] = ConstantValue(read.counts, 0.05, _SOURCE)
        told.append(f"output position {quantity(read.noise, 'm' if model.motion == 'linear' else 'rad')}")
    if not told:
        return model, ""
    lags = [lag for recording in found if (lag := speed_lag(recording)) is not None]
    if lags and constants[SMOOTHING].source == ABSENT and max(lags) <= CONSTANTS[SMOOTHING].upper:
        constants[SMOOTHING] = ConstantValue(float(np.median(lags)), 0.05, _LAG_SOURCE)
        told.append(f"smoothing of the speed {quantity(constants[SMOOTHING].value, 's')}")
    return replace(model, constants=constants), (
        f"model {model.name} states no noise of its sensors (`sensors:` in its file), so that of the recordings is "
        f"taken: {', '.join(told)}"
    )


class _Read(NamedTuple):
    """The noise of one reading of the output encoder [rad, or m], and its part beyond the rounding [counts]."""

    noise: float
    counts: float


def _beyond_counts(recordings: Sequence[Recording], model: Model) -> _Read | None:
    """What an output encoder whose counts alone are stated adds to their rounding; None if it adds hardly anything.

    It is told by the difference of both encoders: an uneven clock moves both alike, and is no noise of either. Each
    position counts from its first reading, which so much noise moves as far as backlash would.
    """
    if model.constants[OUTPUT_COUNTS].source == ABSENT or model.constants[OUTPUT_NOISE].source != ABSENT:
        return None
    both = [r for r in recordings if r.has("motor_position", "output_position") and not r.of_points]
    ratio = model.value("machine.gear_ratio")
    each = []
    for recording in both:
        apart = recording.signals["output_position"] - recording.signals["motor_position"] / ratio
        each.append(polled_noise(apart[np.isfinite(apart)]))
    noise = math.sqrt(sum(one**2 for one in each) / len(each)) if each else 0.0
    count = model.turn / model.value(OUTPUT_COUNTS)
    rounding = math.hypot(count, model.turn / (model.value("sensors.motor_encoder_counts") * ratio)) / math.sqrt(12.0)
    if noise <= CLEARLY_MORE * rounding:
        return None
    return _Read(noise, math.sqrt(noise**2 - rounding**2) / count)


def _noise(recordings: Sequence[Recording], name: str) -> float:
    """The noise of a signal's readings, pooled over the recordings; zero if none has it."""
    each = [_reading(recording, name) for recording in recordings if recording.has(name)]
    return math.sqrt(sum(noise**2 for noise in each) / len(each)) if each else 0.0


def _reading(recording: Recording, name: str) -> float:
    values = recording.signals[name]
    if not recording.of_points:
        return polled_noise(values[np.isfinite(values)])
    return noise_of_points(recording, name) if name == "current" else 0.0  # each point has a motion of its own
