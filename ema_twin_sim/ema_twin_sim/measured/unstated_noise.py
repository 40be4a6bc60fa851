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
from ..model.own_units import ORDER_UNIT
from ..quantities import quantity
from ..reading_noise import noise_of_points, polled_noise, reading_noise, smallest_step
from ..simulation.compared_signals import COMPARED
from ..simulation.sensor_noise import counter_noise
from .speed_lag import speed_lag

_SMOOTHING = "sensors.speed_smoothing"
_OUTPUT_COUNTS, _OUTPUT_NOISE = "sensors.output_encoder_counts", "sensors.output_encoder_noise"
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
    for name, path in ((name, signal.sensor) for name, signal in COMPARED.items() if signal.sensor):
        noise = _noise(found, name)
        if constants[path].source != ABSENT or not noise > 0.0:
            continue
        value, unit = noise, CONSTANTS[path].unit
        counts = unit == ORDER_UNIT
        if counts:
            value, unit = model.turn / (math.sqrt(12.0) * noise), "rad"
        if not CONSTANTS[path].lower <= value <= CONSTANTS[path].upper:
            continue
        constants[path] = ConstantValue(value, 0.0 if counts else 0.05, _SOURCE)
        said, signal = noise, name.replace("_", " ")
        if name == "current" and any(BY_TORQUE in recording.metadata for recording in found):
            said, unit, signal = noise * model.value("machine.torque_constant"), "N m", "torque"
        if model.motion == "linear":
            unit, signal = unit.replace("N m", "N").replace("rad", "m"), signal.replace("torque", "force")
        told.append(f"{signal} {quantity(said, unit)}")
    if (read := _beyond_counts(found, model)) is not None:
        constants[_OUTPUT_NOISE] = ConstantValue(read.counts, 0.05, _SOURCE)
        told.append(f"output position {quantity(read.noise, 'm' if model.motion == 'linear' else 'rad')}")
    if constants[_SMOOTHING].source == ABSENT and (lag := _common_lag(found)) is not None:
        constants[_SMOOTHING] = ConstantValue(lag, 0.05, _LAG_SOURCE)
        told.append(f"smoothing of the speed {quantity(lag, 's')}")
    if not told:
        return model, ""
    return replace(model, constants=constants), (
        f"model {model.name} states no noise of its sensors (`sensors:` in its file), so that of the recordings is "
        f"taken: {', '.join(told)}"
    )


def _common_lag(recordings: Sequence[Recording]) -> float | None:
    """The lag [s] of a drive's speed that most recordings show alike; None if they do not."""
    both = [r for r in recordings if r.has("motor_position", "speed") and not r.of_points]
    lags = [lag for recording in both if (lag := speed_lag(recording)) is not None]
    if len(lags) <= len(both) / 2:
        return None
    common = float(np.median(lags))
    alike = all(common / CLEARLY_MORE < lag < common * CLEARLY_MORE for lag in lags)
    return common if alike and common <= CONSTANTS[_SMOOTHING].upper else None


class _Read(NamedTuple):
    """The noise of one reading of the output encoder [rad, or m], and its part beyond the rounding [counts]."""

    noise: float
    counts: float


def _beyond_counts(recordings: Sequence[Recording], model: Model) -> _Read | None:
    """What an output encoder whose counts alone are stated adds to their rounding; None if it adds hardly anything.

    It is told by the difference of both encoders: an uneven clock moves both alike, and is no noise of either. Each
    position counts from its first reading, which so much noise moves as far as backlash would. Only new readings
    count: between two of them, an encoder that is read less often than the motor's falls behind.
    """
    if model.constants[_OUTPUT_COUNTS].source == ABSENT or model.constants[_OUTPUT_NOISE].source != ABSENT:
        return None
    both = [r for r in recordings if r.has("motor_position", "output_position") and not r.of_points]
    ratio = model.value("machine.gear_ratio")
    each, rounded = [], []
    for recording in both:
        output = recording.signals["output_position"]
        new = np.concatenate([[False], np.diff(output) != 0.0])
        apart = (output - recording.signals["motor_position"] / ratio)[new]
        each.append(reading_noise(apart[np.isfinite(apart)]))
        rounded.append(smallest_step(recording.signals["motor_position"]) / (math.sqrt(12.0) * ratio))
    noise = _pooled(each)
    count = model.turn / model.value(_OUTPUT_COUNTS)
    known = math.hypot(count / math.sqrt(12.0), max([counter_noise(model, "motor") / ratio, *rounded]))
    if noise <= CLEARLY_MORE * known:
        return None
    return _Read(noise, math.sqrt(noise**2 - known**2) / count)


def _noise(recordings: Sequence[Recording], name: str) -> float:
    """The noise of a signal's readings, pooled over the recordings; zero if none has it."""
    return _pooled([_reading(recording, name) for recording in recordings if recording.has(name)])


def _pooled(each: Sequence[float]) -> float:
    return math.sqrt(sum(noise**2 for noise in each) / len(each)) if each else 0.0


def _reading(recording: Recording, name: str) -> float:
    values = recording.signals[name]
    if not recording.of_points:
        return polled_noise(values[np.isfinite(values)])
    return noise_of_points(recording, name) if name == "current" else 0.0  # each point has a motion of its own
