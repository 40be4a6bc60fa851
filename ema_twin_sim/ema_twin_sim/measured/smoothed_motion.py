"""A recording's motion on an even grid: positions, speed and acceleration, smoothed as little as the sensors allow."""

from __future__ import annotations

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import NEARLY_ALL, NEGLIGIBLE, STANDSTILL
from ..model import Model
from ..reading_noise import reading_noise
from ..simulation.sensor_noise import counter_noise
from ..simulation.twin import hold
from .bandwidth import narrowest, narrowest_for_speed, slope
from .smoothing import gaussian, smooth, smooth_way
from .spoilt_samples import despiked

NEEDED = ("motor_position",)
WIDTH = 0.005  # own s, standard deviation of the kernel: about 30 Hz
COUNTER_WIDTH = 0.012  # own s, if the acceleration is a counter's second difference
COUNTER_SPEED_WIDTH = 0.004  # own s, for the speed in that case, which friction depends on
COUNTER_PULL = 0.06  # own s, width over which the integrated speed follows the counter
LEAST_PERIODS = 2.5  # minimum kernel width in sample periods
FEWEST = 10  # samples


def even(recording: Recording) -> tuple[float, np.ndarray, dict[str, np.ndarray], np.ndarray]:
    """(period, time, signals on an even grid without NaN, periods (n,) between the measured samples around each)."""
    period = recording.sample_period
    steps = np.diff(recording.stamps) * 1e-9
    used = {
        name: recording.signals[name]
        for name in (*NEEDED, "current", "speed", "output_position")
        if recording.has(name)
    }
    whole = np.ones(len(recording), bool)
    for values in used.values():
        whole &= np.isfinite(values)
    if whole.sum() < 2:
        raise InputError(f"{recording.name}: has no sample that holds {', '.join(used)} together")
    measured = recording.time[whole]
    used = {name: despiked(values[whole]) for name, values in used.items()}
    if recording.has("load_torque"):
        used["load_torque"] = _held(recording.signals["load_torque"])[whole]
    if whole.all() and np.abs(steps - period).max() < NEGLIGIBLE * period:
        return period, recording.time, used, np.ones(len(whole))
    time = np.arange(int(recording.duration / period + 1e-6) + 1) * period
    signals = {name: np.interp(time, measured, values) for name, values in used.items()}
    after = np.searchsorted(measured, time, side="left").clip(1, len(measured) - 1)
    return period, time, signals, np.rint((measured[after] - measured[after - 1]) / period)


def usual_step(recording: Recording) -> float:
    """Step [s] that nearly all steps between samples stay within, in whole sample periods.

    A computer that logs while doing other work has no even rate. Its longer steps are not gaps, and a kernel as wide as
    one of them bridges it. If the samples have a clock and a few are missing, this is the sample period.
    """
    steps = np.diff(recording.stamps) * 1e-9
    return float(np.rint(np.quantile(steps, NEARLY_ALL) / recording.sample_period)) * recording.sample_period


def smoothed_motion(
    signals: dict[str, np.ndarray],
    time: np.ndarray,
    period: float,
    width: float,
    model: Model,
    reading: float,
    geared: bool,
) -> tuple[np.ndarray, float]:
    """(motion (n, 7) with the columns MOTION, noise of the acceleration [rad/s2]).

    ``reading`` [rad] is the standard deviation of one reading of the motor's counter.
    """
    position = signals["motor_position"]
    _, kernel, noise = differentiator(signals, period, width, model, reading)
    if "speed" in signals:
        smoothing = model.value("sensors.speed_smoothing")
        speed = smooth(signals["speed"], gaussian(period, period))
        speed += smoothing * smooth(signals["speed"], gaussian(period, period, 1))
        acceleration = smooth(signals["speed"], kernel)
        travelled = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * period)])
        angle = travelled + smooth(position - travelled, gaussian(COUNTER_PULL, period))
    else:
        speed_width = max(COUNTER_SPEED_WIDTH, LEAST_PERIODS * period / 2.0)
        if not geared:
            speed_width = narrowest_for_speed(period, reading, speed_width, period / 2.0, STANDSTILL)
        speed = smooth_way(position, gaussian(speed_width, period, 1))
        angle = smooth_way(position, gaussian(speed_width, period))
        acceleration = smooth_way(position, kernel)
    output = signals.get("output_position", angle / model.value("machine.gear_ratio"))
    load = signals.get("load_torque", np.zeros(len(time)))
    return np.stack([time, angle, speed, acceleration, signals["current"], output, load], axis=1), noise


def differentiator(
    signals: dict[str, np.ndarray], period: float, width: float, model: Model, reading: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """(signal (n,), kernel that makes it the acceleration, noise [rad/s2] that its sensor leaves there).

    The speed if it was measured, otherwise the motor's position; ``reading`` as above.
    """
    if "speed" in signals:
        kernel = slope(width, period, model.value("sensors.speed_smoothing"))
        return signals["speed"], kernel, model.value("sensors.speed_noise") * float(np.linalg.norm(kernel))
    kernel = gaussian(width, period, 2)
    return signals["motor_position"], kernel, reading * float(np.linalg.norm(kernel))


def full_rate(recording: Recording, model: Model) -> tuple[np.ndarray, float]:
    """(motion (n, 7) with the columns MOTION, sample period [s]) of a whole recording, with minimal smoothing."""
    if missing := [name for name in ("current", *NEEDED) if not recording.has(name)]:
        raise InputError(f"{recording.name}: has no {' and no '.join(missing)}")
    period, time, signals, _ = even(recording)
    if len(time) < FEWEST:
        raise InputError(f"{recording.name}: {len(time)} samples are too few: at least {FEWEST} are needed")
    reading = max(counter_noise(model, "motor"), reading_noise(signals["motor_position"]))
    least = period
    width = WIDTH if "speed" in signals else narrowest(signals["motor_position"], period, reading, COUNTER_WIDTH, least)
    motion, _ = smoothed_motion(signals, time, period, max(width, least), model, reading, False)
    return motion, period


def _held(load: np.ndarray) -> np.ndarray:
    """A measured load (n,), with missing values held as a twin does."""
    held = load.copy()
    hold(held)
    return held
