"""The gains of a drive's speed controller, if a recording has its setpoint: torque over speed error.

A PI controller demands the torque K (e + 1/T times the integral of e), where e is the setpoint minus the speed. The
motor's torque follows some samples later, because of the current loop's lag and the drive's filters. If that does not
explain the torque, the drive is of another kind, and no gains are given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import ALL_BUT_SPIKES, SMALL
from ..measured.smoothing import gaussian, smooth
from ..model.constants import CONSTANTS

_LAGS = np.arange(0.0, 12.25, 0.25)  # samples by which the torque may lag
_WIDTHS = (0.0, 2.0, 5.0, 12.0, 30.0)  # samples of smoothing against noise; the first that works is used
_FEWEST = 200  # samples


@dataclass(frozen=True)
class DriveGains:
    """Gains of a PI speed controller: K [N m s/rad] and T [s]."""

    speed_gain: float
    integral_time: float


def drive_gains(recording: Recording, torque_constant: float) -> DriveGains | None:
    """The gains that a recording (SI, at the motor's shaft) shows; None if it does not show a PI controller."""
    drive = recording.drive
    told = drive is not None and recording.has("speed_setpoint", "speed")
    if drive is None or not told or recording.of_points or len(recording) < _FEWEST:
        return None
    torque = recording.signals[drive] * (torque_constant if drive == "current" else 1.0)
    error = recording.signals["speed_setpoint"] - recording.signals["speed"]
    if not (np.isfinite(torque).all() and np.isfinite(error).all()):
        return None
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (error[1:] + error[:-1]) * np.diff(recording.time))])
    within = np.abs(torque) < (1.0 - SMALL) * np.quantile(np.abs(torque), ALL_BUT_SPIKES)  # where no torque limit acts
    if np.count_nonzero(within) < _FEWEST:
        return None
    signals = np.stack([error, summed, torque])
    for width in _WIDTHS:
        if found := _by_lag(_smoothed(signals, width), within):
            return found
    return None


def _smoothed(signals: np.ndarray, width: float) -> np.ndarray:
    """Signals (k, n), smoothed by the same kernel, which leaves a linear law between them unchanged."""
    if not width:
        return signals
    kernel = gaussian(width, 1.0, 0)
    return np.stack([smooth(signal, kernel) for signal in signals])


def _by_lag(signals: np.ndarray, within: np.ndarray) -> DriveGains | None:
    """The gains by the lag that explains the torque best, from error, its integral and torque (3, n)."""
    error, summed, torque = signals
    place = np.arange(len(torque), dtype=float)
    best, least = None, SMALL**2 * float(np.nanvar(torque[within]))
    for lag in _LAGS:
        columns = np.stack([np.interp(place - lag, place, error), np.interp(place - lag, place, summed)], axis=1)
        kept = within & np.isfinite(torque) & np.isfinite(columns).all(axis=1)
        rows = np.column_stack([columns[kept], np.ones(int(kept.sum()))])
        found, *_ = np.linalg.lstsq(rows, torque[kept], rcond=None)
        left = float(np.mean((torque[kept] - rows @ found) ** 2))
        if left < least and found[0] > 0.0 and found[1] > 0.0:
            best, least = found, left
    if best is None:
        return None
    gains = DriveGains(float(best[0]), float(best[0] / best[1]))
    times = CONSTANTS["drive.integral_time"]
    return gains if times.lower <= gains.integral_time <= times.upper else None  # else no controller has it
