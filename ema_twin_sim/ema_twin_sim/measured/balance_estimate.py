"""Inertia and friction by one linear regression of the drive torque on the measured motion.

A first estimate for unknown machines. It sets the scale of everything else, and the start of a search. It needs no
start value and no number with a unit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.recording import Recording, spread

from ..criteria import CONTRADICTED, MOSTLY, NEGLIGIBLE, SMALL
from ..model import Model
from ..simulation.sensor_noise import counter_noise
from .held_readings import noise_of_held, noise_of_readings
from .smoothing import gaussian, smooth_at

FIRST_WIDTH = 10.0  # sample periods: the kernel's standard deviation before a time scale is known
LEAST_WIDTH = 2.5  # sample periods
WIDER = 1.5  # times a kernel's width, until the acceleration is quiet
PASSES = 3  # estimates, each with the kernel that the previous one suggests
KERNEL = 0.07  # of the machine's own time sqrt(J / T): the kernel's standard deviation
ROWS = 200  # no estimate with fewer rows
LOADS = ((3, 4, 5, 6), (6,))  # columns that depend on the angle, plus a constant load
"""Loads that are tried with inertia and friction. If a motion swings about one angle, acceleration is proportional to
the angle: any load over the angle then replaces the inertia, whose order of magnitude only shows without such loads.
Hardly any swing is pure, and a load of another shape moves it: least squares then takes that load for the acceleration
of a huge inertia, with a small standard error (``_replaced``)."""


@dataclass(frozen=True)
class BalanceEstimate:
    """Inertia, viscous coefficient and Coulomb torque at the motor, SI."""

    inertia: float
    viscous: float
    coulomb: float


def estimate_balance(recordings: Sequence[Recording], model: Model, torque: float) -> BalanceEstimate | None:
    """The estimate from recordings of a motion; ``torque`` is the drive's rms torque. None if there is no motion.

    If no inertia is significant, it is set to its standard error, or to what makes a SMALL part of the torque if that
    is less: it is hardly larger.
    """
    moving = [r for r in spread(recordings) if r.has("current", "motor_position") and not r.of_points and len(r) > ROWS]
    found: BalanceEstimate | None = None
    for _ in range(PASSES):
        own_time = None if found is None else math.sqrt(found.inertia / torque)
        parts = [_rows(recording, model, own_time) for recording in moving]
        if not parts:
            return None
        shown = (_regressed(parts, loads) for loads in LOADS)
        estimate = next((estimate for estimate in shown if estimate is not None), None)
        if estimate is None:
            return found or _regressed(parts, LOADS[0], significant=False)
        found = estimate
    return found


def _rows(recording: Recording, model: Model, own_time: float | None) -> tuple[np.ndarray, np.ndarray]:
    """(columns (m, k), torque (m,)) of a recording, two kernel widths apart; the last column is the constant.

    Where the acceleration is noisy, the kernel is wider: its noise makes an inertia too small, which would suggest a
    kernel that is narrower still. None may be quiet, since a kernel that is too wide leaves nothing of the motion: then
    it is the quietest.
    """
    period = recording.sample_period
    width = FIRST_WIDTH * period if own_time is None else KERNEL * own_time
    widest = max(NEGLIGIBLE * recording.duration, LEAST_WIDTH * period)
    width = max(min(width, widest), LEAST_WIDTH * period)
    signals = _even(recording)
    if "speed" in signals:
        reading = noise_of_readings(signals["speed"])
    else:
        reading = noise_of_held(counter_noise(model, "motor"), signals["motor_position"])
    best = _smoothed(signals, model, period, width, reading)
    while best[-1] > SMALL and width < widest:
        width = min(WIDER * width, widest)
        best = min(best, _smoothed(signals, model, period, width, reading), key=lambda one: one[-1])
    columns, drive, _ = best
    return columns, drive


def _even(recording: Recording) -> dict[str, np.ndarray]:
    """The signals of a recording on an even grid."""
    time = np.arange(int(recording.duration / recording.sample_period) + 1) * recording.sample_period
    signals = {}
    for name in ("current", "motor_position", "speed", "load_torque"):
        if recording.has(name):
            known = np.isfinite(recording.signals[name])
            signals[name] = np.interp(time, recording.time[known], recording.signals[name][known])
    return signals


def _smoothed(
    signals: dict[str, np.ndarray], model: Model, period: float, width: float, reading: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """(columns (m, k), torque (m,), rms noise of the acceleration over its rms) through a kernel of this ``width`` [s].

    ``reading`` is the noise of a sample of the speed [rad/s], or of the position [rad] if no speed was measured. The
    share is infinite where nothing moves.
    """
    plain, slope, bend = (gaussian(width, period, order) for order in (0, 1, 2))
    count, half = len(signals["motor_position"]), max(map(len, (plain, slope, bend))) // 2
    centres = np.arange(half, count - half, max(1, round(2.0 * width / period)))

    def through(kernel: np.ndarray, name: str) -> np.ndarray:
        smoothed = np.empty(len(centres))
        smooth_at(signals[name], np.ascontiguousarray(kernel[::-1]), centres, smoothed)
        return smoothed

    position = through(plain, "motor_position")
    if "speed" in signals:
        differentiator = slope
        speed, acceleration = through(plain, "speed"), through(differentiator, "speed")
    else:
        differentiator = bend
        speed, acceleration = through(slope, "motor_position"), through(differentiator, "motor_position")
    drive = model.value("machine.torque_constant") * through(plain, "current")
    if "load_torque" in signals:  # a measured load opposes positive motion
        drive = drive - through(plain, "load_torque")
    angle = position / model.value("machine.gear_ratio")
    columns = [acceleration, speed, np.sign(speed), np.sin(angle), np.cos(angle), angle, np.ones(len(centres))]
    kept = np.abs(speed) > NEGLIGIBLE * np.abs(speed).max(initial=0.0)
    square = float(np.mean(acceleration[kept] ** 2)) if kept.any() else 0.0
    noise = reading * float(np.linalg.norm(differentiator))
    return np.stack(columns, 1)[kept], drive[kept], noise / math.sqrt(square) if square > 0.0 else math.inf


def _regressed(
    parts: Sequence[tuple[np.ndarray, np.ndarray]], loads: Sequence[int], *, significant: bool = True
) -> BalanceEstimate | None:
    """Least squares over all recordings with some ``loads``; None if the inertia is not ``significant``.

    That it is if it is far beyond its standard error, and if the loads cannot stand for it.
    """
    columns = np.concatenate([part[0][:, [0, 1, 2, *loads]] for part in parts])
    torque = np.concatenate([part[1] for part in parts])
    if len(torque) < 3 * columns.shape[1]:
        return None
    size = np.sqrt(np.mean(columns**2, axis=0))
    size[size == 0.0] = 1.0
    scaled = columns / size
    values, *_ = np.linalg.lstsq(scaled, torque, rcond=1e-9)
    left = torque - scaled @ values
    spread = float(left @ left) / max(len(torque) - len(values), 1)
    covariance = spread * np.linalg.pinv(scaled.T @ scaled, hermitian=True)
    inertia, viscous, coulomb = values[:3] / size[:3]
    error = math.sqrt(covariance[0, 0]) / size[0]
    if significant and inertia < CONTRADICTED * error:
        return None
    simpler = loads != LOADS[-1]  # there are fewer loads to try, which leave the inertia more of the torque
    if significant and simpler and _replaced(scaled, float(values[0]), math.sqrt(spread)):
        return None
    if not significant:
        hardly_more = SMALL * float(np.sqrt(np.mean(torque**2))) / size[0]
        inertia = min(max(float(inertia), error), hardly_more)
    if inertia <= 0.0:
        return None
    return BalanceEstimate(float(inertia), max(float(viscous), 0.0), max(float(coulomb), 0.0))


def _replaced(scaled: np.ndarray, inertial: float, left: float) -> bool:
    """Whether other columns of the regression can stand for the acceleration, its first (m, k), each of rms one.

    They can if the acceleration mostly goes with them, and if its remainder takes less of the torque than is ``left``
    over [N m]: what is missing among the columns (no load is of exactly their shapes) may then be all that the
    remainder shows. ``inertial`` is the rms torque of the inertia [N m].
    """
    others = scaled[:, 1:]
    with_them, *_ = np.linalg.lstsq(others, scaled[:, 0], rcond=1e-9)
    own = float(np.mean((scaled[:, 0] - others @ with_them) ** 2))
    return 1.0 - own > MOSTLY and inertial * math.sqrt(own) < left
