"""Choice between two sensors of the motion: a speed is left out if the position shows the acceleration better.

Many drives log a speed that is a difference of counts, in steps of one count per sample. Its derivative is mostly
noise, and a regression on a noisy acceleration makes the inertia too small and hides what else is missing.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import NEGLIGIBLE, SMALL
from ..model import Model
from ..model.matching import matched
from ..reading_noise import reading_noise
from ..simulation.sensor_noise import counter_noise
from .smoothing import gaussian, smooth

LEAST_PERIODS = 2.5  # narrowest kernel, in sample periods
AS_QUIET = math.sqrt(1.5)  # a position's second derivative is as quiet as a speed's first at this times s_p / s_v
ENOUGH = 200_000  # samples that are looked at


def as_measured(recording: Recording, model: Model) -> Recording:
    """The recording as ``model.matching.matched`` gives it, without a speed that is noisier than the position shows it.

    Raises InputError if recording and model do not belong together.
    """
    found = matched(recording, model)
    if not found.has("speed", "motor_position") or found.of_points or not _noisier(found, model):
        return found
    signals = {name: values for name, values in found.signals.items() if name != "speed"}
    warning = (
        f"{found.name}: its speed is too noisy for the acceleration; the motion is taken from the position instead"
    )
    return replace(found, signals=signals, warnings=(*found.warnings, warning))


def _noisier(recording: Recording, model: Model) -> bool:
    """Whether the speed's derivative is still noisy with the kernel from which on the position's is quieter.

    Noisy is a noise that is more than a small share of the acceleration. The widths at which a Gaussian kernel's second
    derivative of the position and its first of the speed are equally quiet follow from the norms of its derivatives.
    """
    speed, position = (recording.signals[name][:ENOUGH] for name in ("speed", "motor_position"))
    known = np.isfinite(speed) & np.isfinite(position)
    if known.sum() < 4:
        return False
    time = recording.time[:ENOUGH]
    period = recording.sample_period
    speed_noise = max(reading_noise(speed[known]), _rounding(speed[known]))
    position_noise = max(counter_noise(model, "motor"), reading_noise(position[known]))
    if not speed_noise > 0.0:
        return False
    width = max(AS_QUIET * position_noise / speed_noise, LEAST_PERIODS * period)
    if width > NEGLIGIBLE * recording.duration:
        return False
    grid = np.arange(int((time[-1] - time[0]) / period) + 1) * period + time[0]
    slope = gaussian(width, period, 1)
    if len(grid) < 4 * len(slope):
        return False
    acceleration = smooth(np.interp(grid, time[known], speed[known]), slope)
    return speed_noise * float(np.linalg.norm(slope)) > SMALL * float(np.sqrt(np.mean(acceleration**2)))


def _rounding(values: np.ndarray) -> float:
    """Standard deviation of the rounding of values (n,): of their smallest step."""
    levels = np.unique(values)
    return float(np.diff(levels).min()) / math.sqrt(12.0) if len(levels) > 1 else 0.0
