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

from ..criteria import CONTRADICTED, NEGLIGIBLE, SMALL
from ..model import Model
from .smoothing import gaussian, smooth

FIRST_WIDTH = 10.0  # sample periods: the kernel's standard deviation before a time scale is known
LEAST_WIDTH = 2.5  # sample periods
PASSES = 3  # estimates, each with the kernel that the previous one suggests
KERNEL = 0.07  # of the machine's own time sqrt(J / T): the kernel's standard deviation
ROWS = 200  # no estimate with fewer rows
LOADS = ((3, 4, 5, 6), (6,))  # columns that depend on the angle, plus a constant load
"""Loads that are tried with inertia and friction. If a motion swings about one angle, acceleration is proportional to
the angle: any load over the angle then replaces the inertia, whose order of magnitude only shows without such loads."""


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
    """(columns (m, k), torque (m,)) of a recording, two kernel widths apart; the last column is the constant."""
    period = recording.sample_period
    time = np.arange(int(recording.duration / period) + 1) * period
    width = FIRST_WIDTH * period if own_time is None else max(KERNEL * own_time, LEAST_WIDTH * period)
    width = max(min(width, NEGLIGIBLE * recording.duration), LEAST_WIDTH * period)
    signals = {}
    for name in ("current", "motor_position", "speed", "load_torque"):
        if recording.has(name):
            known = np.isfinite(recording.signals[name])
            signals[name] = np.interp(time, recording.time[known], recording.signals[name][known])
    plain, slope = gaussian(width, period), gaussian(width, period, 1)
    position = smooth(signals["motor_position"], plain)
    if "speed" in signals:
        speed, acceleration = smooth(signals["speed"], plain), smooth(signals["speed"], slope)
    else:
        speed = smooth(signals["motor_position"], slope)
        acceleration = smooth(signals["motor_position"], gaussian(width, period, 2))
    drive = model.value("machine.torque_constant") * smooth(signals["current"], plain)
    if "load_torque" in signals:  # a measured load opposes positive motion
        drive = drive - smooth(signals["load_torque"], plain)
    half = len(plain) // 2
    kept = np.arange(half, len(time) - half, max(1, round(2.0 * width / period)))
    kept = kept[np.abs(speed[kept]) > NEGLIGIBLE * np.abs(speed).max()]
    angle = position / model.value("machine.gear_ratio")
    columns = [acceleration, speed, np.sign(speed), np.sin(angle), np.cos(angle), angle, np.ones(len(time))]
    return np.stack(columns, 1)[kept], drive[kept]


def _regressed(
    parts: Sequence[tuple[np.ndarray, np.ndarray]], loads: Sequence[int], *, significant: bool = True
) -> BalanceEstimate | None:
    """Least squares over all recordings with some ``loads``; None if the inertia is not ``significant``."""
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
    if not significant:
        hardly_more = SMALL * float(np.sqrt(np.mean(torque**2))) / size[0]
        inertia = min(max(float(inertia), error), hardly_more)
    if inertia <= 0.0:
        return None
    return BalanceEstimate(float(inertia), max(float(viscous), 0.0), max(float(coulomb), 0.0))
