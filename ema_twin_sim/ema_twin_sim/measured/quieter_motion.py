"""Choice between two sensors of the motion: a speed is left out if the position shows the acceleration better.

Many drives log a speed that is a difference of counts, in steps of one count per sample. Its derivative is mostly
noise, and a regression on a noisy acceleration makes the inertia too small and hides what else is missing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import SMALL
from ..listing import first_of
from ..model import Model
from ..model.matching import BY_SPEED, matched
from ..reading_noise import reading_noise, smallest_step
from ..simulation.sensor_noise import counter_noise
from .held_torque import telling_repeats
from .smoothed_motion import LEAST_PERIODS
from .smoothing import gaussian, smooth
from .spoilt_samples import without_spoilt_motion
from .way_by_speed import standing_position, way_by_speed

MOST_PERIODS = 5.0
"""Widest kernel, in sample periods, with which the choice is made: wider ones favour the position ever more."""
AS_QUIET = math.sqrt(1.5)  # a position's second derivative is as quiet as a speed's first at this times s_p / s_v
PARTS = 40  # of a recording, over which the position's way is compared with the speed's
STRETCHES, STRETCH = 10, 20_000  # stretches of a long recording that are examined, and samples of each


class Measured(list[Recording]):
    """Recordings that ``as_measured`` gave; it gives them back as they are."""


def as_measured(recordings: Sequence[Recording], model: Model) -> Measured:
    """The recordings as ``model.matching.matched`` gives them, without spoilt samples and without noisy speeds.

    Whether a speed is noisier than the position is decided once for all of them, since they come from the same sensors.
    The first recording without its speed carries the warning. Raises InputError if recordings and model do not belong
    together.
    """
    if isinstance(recordings, Measured):
        return recordings
    read = [matched(telling_repeats(without_spoilt_motion(recording)), model) for recording in recordings]
    found = _told_once(recordings, read)
    coarse = {k: both for k, one in enumerate(found) if (both := _noise_and_acceleration(one, model)) is not None}
    noise, acceleration = (
        (float(sum(column)) for column in zip(*coarse.values(), strict=True)) if coarse else (0.0, 0.0)
    )
    if not noise > SMALL**2 * acceleration:
        return Measured(found)
    named = first_of([found[k].name for k in coarse])
    warning = f"{named}: the speed is too noisy for the acceleration; the motion is taken from the position instead"
    return Measured(
        replace(
            one,
            signals={name: values for name, values in one.signals.items() if name != "speed"},
            warnings=(*one.warnings, warning) if k == min(coarse) else one.warnings,
        )
        if k in coarse
        else one
        for k, one in enumerate(found)
    )


def _told_once(recordings: Sequence[Recording], found: Sequence[Recording]) -> list[Recording]:
    """The ``found`` recordings, without warnings that the given ``recordings`` lack and that an earlier one has.

    The first one with such a warning carries it for all.
    """
    alike: dict[str, list[int]] = {}
    for k, (given, one) in enumerate(zip(recordings, found, strict=True)):
        for warning in one.warnings[len(given.warnings) :]:
            those = alike.setdefault(warning.removeprefix(f"{one.name}: "), [])
            if k not in those:
                those.append(k)
    told = [list(given.warnings) for given in recordings]
    for text, those in alike.items():
        told[those[0]].append(f"{first_of([found[k].name for k in those])}: {text}")
    return [
        one if one.warnings == tuple(warnings) else replace(one, warnings=tuple(warnings))
        for one, warnings in zip(found, told, strict=True)
    ]


def _noise_and_acceleration(recording: Recording, model: Model) -> tuple[float, float] | None:
    """Mean squares [rad2/s4] of the noise of a speed's derivative and of this derivative itself, noise included.

    With the kernel from which on the position's second derivative is as quiet; None if that kernel is a wide one, so
    that the speed is the better sensor. The width follows from the norms of a Gaussian kernel's derivatives.
    """
    if recording.of_points or not recording.has("speed", "motor_position"):
        return None
    if BY_SPEED in recording.metadata:  # the integral of this very speed is no second sensor
        return None
    if standing_position(recording) is not None:  # it is quiet, and shows nothing
        return None
    if not _agree(recording):  # one of them is in another unit, as consistency.py will say
        return None
    speeds, positions = (list(_stretches(recording.signals[name])) for name in ("speed", "motor_position"))
    speed_noise = float(np.median([max(reading_noise(part), smallest_step(part) / math.sqrt(12.0)) for part in speeds]))
    position_noise = max(counter_noise(model, "motor"), float(np.median([reading_noise(part) for part in positions])))
    period = recording.sample_period
    if not speed_noise > 0.0 or AS_QUIET * position_noise > MOST_PERIODS * period * speed_noise:
        return None
    slope = gaussian(max(AS_QUIET * position_noise / speed_noise, LEAST_PERIODS * period), period, 1)
    squares = [float(np.mean(smooth(part, slope) ** 2)) for part in speeds if len(part) > 4 * len(slope)]
    if not squares:
        return None
    return (speed_noise * float(np.linalg.norm(slope))) ** 2, float(np.mean(squares))


def _agree(recording: Recording) -> bool:
    """Whether the position goes as far as the speed says, or does not show it; in the beginning of a long recording."""
    most = STRETCHES * STRETCH
    if len(recording) > most:
        recording = recording.between(None, float(recording.stamps[most] - recording.stamps[0]) * 1e-9)
    times = way_by_speed(recording, max(1, len(recording) // PARTS))
    return times is None or abs(times - 1.0) <= SMALL


def _stretches(values: np.ndarray) -> Iterator[np.ndarray]:
    """The known values of a signal (n,); of a long one, those of some stretches that are spread over it."""
    whole = len(values) <= STRETCHES * STRETCH
    for start in (0,) if whole else np.linspace(0, len(values) - STRETCH, STRETCHES).astype(int):
        part = values if whole else values[start : start + STRETCH]
        yield part[np.isfinite(part)]
