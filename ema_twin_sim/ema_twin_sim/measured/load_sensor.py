"""Whether a torque that a sensor measured behind the machine is its load: then the drive's torque follows it, and rises
with it; one that falls where the load rises tells that the sensor counts the other way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import CORRELATION, FEWEST_ROWS, NEGLIGIBLE, PART, SIGNIFICANT, TOO_MUCH
from ..reading_noise import reading_noise
from .smoothing import gaussian, smooth
from .spoilt_samples import despiked

_WIDTH = 10.0  # samples over which all is smoothed, and
_SHARE = 0.002  # of a recording's
_ENDS = 4.0  # widths at either end that are left out
_SPEED = 1  # column of a row
_MOTION = 5  # columns of what the motion takes: acceleration, speed, its direction, a constant, and what drifts


def follows_load(recordings: Sequence[Recording]) -> bool:
    """Whether the drive's torque follows the load that was measured, beside what the motion takes.

    True where that cannot be told. A sensor in an unloaded joint tells its own offset, which drifts; taken for a load,
    that would stand in the friction's place.
    """
    likeness = _likeness(recordings)
    return likeness is None or abs(likeness) >= PART


def falls_with_load(recordings: Sequence[Recording]) -> bool:
    """Whether the drive's torque falls where the load rises, as where the sensor counts the other way.

    Whatever moves a machine, its drive has to hold what stands against it beside inertia and friction. A screw that
    locks itself is driven down against its load, though, but not up: asked of each direction by itself, surely.
    """
    rows = _all_rows(recordings)
    forward = rows[:, _SPEED] > 0.0
    return all(_surely_falls(part) for part in (rows[forward], rows[~forward]))


def _likeness(recordings: Sequence[Recording]) -> float | None:
    """The correlation of load and drive's torque beside what the motion takes; None where it cannot be told.

    That is without a drive's torque or a motion, or with a load that changes by no more than its sensor's noise.
    """
    rows = _all_rows(recordings)
    return _likeness_of(rows) if len(rows) >= FEWEST_ROWS and _load_shows(rows, recordings) else None


def _surely_falls(rows: np.ndarray) -> bool:
    """Whether torque falls as load rises, by more than chance lets it; rows of one kernel share some of their noise."""
    if len(rows) < FEWEST_ROWS:
        return False
    likeness = _likeness_of(rows)
    return likeness is not None and likeness <= -max(PART, SIGNIFICANT * math.sqrt(CORRELATION / len(rows)))


def _all_rows(recordings: Sequence[Recording]) -> np.ndarray:
    """The rows (n, ``_MOTION`` + 2) of all recordings whose motion was recorded beside a load."""
    parts = [_rows(r) for r in _loaded(recordings)]
    return np.concatenate([part for part in parts if part is not None] or [np.zeros((0, _MOTION + 2))])


def _loaded(recordings: Sequence[Recording]) -> list[Recording]:
    return [r for r in recordings if r.has("load_torque") and not r.of_points]


def _load_shows(rows: np.ndarray, recordings: Sequence[Recording]) -> bool:
    """Whether the load changes by more than its sensor's noise."""
    load = rows[:, _MOTION]
    noise = max(map(_load_noise, _loaded(recordings)), default=0.0)
    return bool(np.std(load) >= max(NEGLIGIBLE * float(np.sqrt(np.mean(load**2))), TOO_MUCH * noise))


def _likeness_of(rows: np.ndarray) -> float | None:
    motion, load, torque = rows[:, :_MOTION], rows[:, _MOTION], rows[:, _MOTION + 1]
    by_load, by_torque = _beside(motion, load), _beside(motion, torque)
    both = float(np.linalg.norm(by_load) * np.linalg.norm(by_torque))
    return float(by_load @ by_torque) / both if both > 0.0 else None


def _load_noise(recording: Recording) -> float:
    """Standard deviation that the noise of a load's sensor has once it is smoothed."""
    load = recording.signals["load_torque"]
    return reading_noise(_whole(load)) * float(np.linalg.norm(_kernel(recording))) if np.isfinite(load).any() else 0.0


def _kernel(recording: Recording, derivative: int = 0) -> np.ndarray:
    return gaussian(_width(recording), 1.0, derivative)


def _width(recording: Recording) -> float:
    return max(_WIDTH, _SHARE * len(recording))


def _rows(recording: Recording) -> np.ndarray | None:
    """Rows (n, ``_MOTION`` + 2) of a recording a kernel apart, load and drive's torque last; None without a motion."""
    drive = next((name for name in ("current", "motor_torque") if recording.has(name)), None)
    move = next((name for name in ("speed", "motor_position") if recording.has(name)), None)
    if drive is None or move is None:
        return None
    if not all(np.isfinite(recording.signals[name]).any() for name in (drive, move, "load_torque")):
        return None
    width, plain, slope = _width(recording), _kernel(recording), _kernel(recording, 1)
    if move == "speed":
        speed, acceleration = (smooth(_whole(recording.signals["speed"]), kernel) for kernel in (plain, slope))
    else:
        position = _whole(recording.signals["motor_position"])
        speed, acceleration = smooth(position, slope), smooth(position, _kernel(recording, 2))
    load, torque = (smooth(_whole(recording.signals[name]), plain) for name in ("load_torque", drive))
    drift = np.linspace(-1.0, 1.0, len(speed))
    rows = np.stack([acceleration, speed, np.sign(speed), np.ones(len(speed)), drift, load, torque], axis=1)
    kept = np.arange(round(_ENDS * width), len(rows) - round(_ENDS * width), max(1, round(width)))
    return rows[kept[np.abs(speed[kept]) > NEGLIGIBLE * np.abs(speed).max()]]


def _whole(values: np.ndarray) -> np.ndarray:
    """The values (n,) without transmission errors; where one is missing, as a straight line has it."""
    known = np.isfinite(values)
    return despiked(np.interp(np.arange(len(values)), np.flatnonzero(known), values[known]))


def _beside(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """What columns (n, k) leave of values (n,)."""
    size = np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
    found, *_ = np.linalg.lstsq(columns / size, values, rcond=None)
    left: np.ndarray = values - columns / size @ found
    return left
