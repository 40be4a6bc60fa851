"""Whether a torque measured by a sensor behind the machine is its load.

Then the drive's torque follows it and rises with it. If the drive's torque falls where the load rises, the sensor has
the opposite sign.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import CORRELATION, FEWEST_ROWS, MOSTLY, NEGLIGIBLE, PART, SIGNIFICANT, SMALL, TOO_MUCH
from ..reading_noise import polled_noise, reading_noise, smallest_step
from .exact_factor import exact_factor
from .smoothing import gaussian, smooth
from .spoilt_samples import despiked

_WIDTH = 10.0  # samples over which all is smoothed, at least
_SHARE = 0.002  # the same as a share of the recording
_ENDS = 4.0  # widths at each end that are left out
_FEWEST_POINTS = 8  # more than numbers fitted to them
_SPEED = 1  # column of a row
_MOVING = 3  # of these columns, the first ones, which are zero at rest
_MOTION = 5  # columns for the motion: acceleration, speed, its sign, a constant, and drift


def follows_load(recordings: Sequence[Recording]) -> bool:
    """Whether the drive's torque follows the measured load, once the torque of the motion is regressed out.

    True if that cannot be decided. A sensor in an unloaded joint measures its own offset, which drifts; taken for a
    load, it would stand in for friction.
    """
    likeness = _likeness(recordings)
    return likeness is None or abs(likeness) >= PART


def times_current(recordings: Sequence[Recording]) -> float | None:
    """The factor [N m/A] by which the load is the current, to the last digits; None if it is not.

    Then no sensor measured it: the drive computed it from the current, and it opposes nothing.
    """
    both = [r for r in recordings if r.has("current", "load_torque")]
    pairs = [np.stack([r.signals["load_torque"], r.signals["current"]]) for r in both]
    return exact_factor(*np.concatenate(pairs, axis=1)) if pairs else None


def load_varies(recording: Recording) -> bool:
    """Whether a recording has a load that changes by more than its sensor's noise, its smallest step and its drift.

    A sensor that bears none, or always the same, tells nothing. Of operating points, each of which may be a mean,
    nothing tells the noise: there a share of the largest load must change.
    """
    load = recording.signals["load_torque"] if recording.has("load_torque") else np.zeros(0)
    known = load[np.isfinite(load)]
    if recording.of_points:
        return len(known) > 1 and float(np.ptp(known)) > NEGLIGIBLE * float(np.abs(known).max())
    if len(known) < FEWEST_ROWS or not np.ptp(known) > 0.0:
        return False
    drift = np.stack([np.ones(len(known)), np.linspace(-1.0, 1.0, len(known))], axis=1)
    changes = float(np.std(_beside(drift, despiked(known))))
    return changes > max(TOO_MUCH * polled_noise(known), smallest_step(known))


def torque_per_current(recordings: Sequence[Recording]) -> float | None:
    """The factor on the current [N m/A] by which it drives the measured load beside the motion; None if it does not.

    By regression of the load: what the current drives beyond inertia and friction. It is a start for a fit. A load that
    hardly goes with the current is a sensor's offset.
    """
    found = _both_beside_motion([r for r in recordings if r.has("current", "load_torque")])
    if found is None or found[0] < PART:
        return None
    _, load, drive = found
    return float(load @ drive) / float(drive @ drive)


def load_over_motor_torque(recordings: Sequence[Recording]) -> float | None:
    """The factor by which the load changes more than the motor's torque does; None if they hardly go together.

    Both without the torque of the motion. Behind a gear whose ratio was not reckoned with, it is about that ratio:
    neither torque is free of errors, so this is the mean of both regressions.
    """
    both = [r for r in recordings if r.has("motor_torque", "load_torque")]
    both = [replace(r, signals={n: v for n, v in r.signals.items() if n != "current"}) for r in both]
    found = _both_beside_motion(both)
    if found is None or abs(found[0]) < MOSTLY:
        return None
    _, load, drive = found
    return float(np.linalg.norm(load) / np.linalg.norm(drive))


def _both_beside_motion(recordings: Sequence[Recording]) -> tuple[float, np.ndarray, np.ndarray] | None:
    """Correlation of load and drive torque, and both (n,), with the motion regressed out; None if rows are few.

    Recordings whose load does not change do not count.
    """
    varied = [r for r in recordings if load_varies(r)]
    rows = np.concatenate([*(_rows_of_points(r) for r in varied if r.of_points), _all_rows(varied)])
    return _alike(rows) if len(rows) > _MOTION + _FEWEST_POINTS else None


def left_of_the_drive(recordings: Sequence[Recording]) -> tuple[float, float] | None:
    """What the load leaves of the drive's changes (rms, as a share): alone, and with the motion; None if it shows none.

    With the motion, 1.0 if inertia and friction would have opposite signs, which no machine has. If they act against
    the load's sign, the sensor counts the other way: then the drive must feed the motion, as friction needs, or it is
    1.0 too. Part of the friction may be proportional to the load: it acts as the motion's torque does, and the load has
    the greater share. The drive is the current, or else the motor's torque. Operating points do not accelerate.
    """
    rows, _ = _rows_or_points(recordings)
    motion, load, drive = rows[:, :_MOVING], rows[:, _MOTION], rows[:, _MOTION + 1]
    motion = motion[:, [np.ptp(column) > 0.0 for column in motion.T]] if len(rows) else motion
    if len(rows) < FEWEST_ROWS or not motion.size or np.ptp(drive) == 0.0:
        return None
    constant = np.ones((len(rows), 1))
    alone = _beside(np.column_stack([constant, load]), drive)
    changes, feeds = float(np.std(drive)), float(drive @ rows[:, _SPEED])

    def together(*friction: np.ndarray) -> float:
        """What the load leaves with the motion, and beside ``friction`` (n,) that is proportional to it."""
        columns = np.column_stack([constant, load, motion, *friction])
        size = np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
        found = np.linalg.lstsq(columns / size, drive, rcond=None)[0] / size
        parts = (found * np.std(columns, axis=0))[2 : 2 + motion.shape[1]] / changes
        most = parts[np.argmax(np.abs(parts))]
        opposed = min(parts.max(), -parts.min()) > SMALL or (most * found[1] < 0.0 and most * feeds < 0.0)
        if friction and not 0.0 < found[-1] * np.sign(most) < abs(found[1]):
            opposed = True
        return 1.0 if opposed else float(np.std(drive - columns @ found)) / changes

    left = together()
    way = np.sign(rows[:, _SPEED])
    if np.ptp(way) > 0.0:
        left = min(left, together(way * np.abs(load)))
    return float(np.std(alone)) / changes, left


def falls_with_load(recordings: Sequence[Recording]) -> bool:
    """Whether the drive's torque falls where the load rises, so that the sensor has the opposite sign.

    Whatever moves a machine, its drive must hold the opposing load in addition to inertia and friction. A self-locking
    screw, however, is driven down against its load but not up. So the fall must be significant in each direction
    separately. Operating points at rest have none.
    """
    rows, of_points = _rows_or_points(recordings)
    forward = rows[:, _SPEED] > 0.0
    if not of_points:
        return all(_surely_falls(part) for part in (rows[forward], rows[~forward]))
    moving = rows[:, _SPEED] != 0.0
    parts = (rows[moving & forward], rows[moving & ~forward]) if moving.any() else (rows,)
    return all(_points_surely_fall(part) for part in parts)


def _likeness(recordings: Sequence[Recording]) -> float | None:
    """Correlation of load and drive torque with the motion regressed out; None if it cannot be determined.

    That is without drive torque or motion data, or with a load that changes by no more than its sensor's noise.
    """
    rows = _all_rows(recordings)
    return _likeness_of(rows) if len(rows) >= FEWEST_ROWS and _load_shows(rows, recordings) else None


def _surely_falls(rows: np.ndarray) -> bool:
    """Whether torque falls with load by more than chance; rows within one kernel share some of their noise."""
    if len(rows) < FEWEST_ROWS:
        return False
    likeness = _likeness_of(rows)
    return likeness is not None and likeness <= -max(PART, SIGNIFICANT * math.sqrt(CORRELATION / len(rows)))


def _points_surely_fall(rows: np.ndarray) -> bool:
    """The same for operating points, which are independent, so that fewer suffice."""
    free = len(rows) - 1 - int(rows[:, :_MOTION].any(axis=0).sum())
    likeness = _likeness_of(rows) if free >= _FEWEST_POINTS else None
    if likeness is None or likeness > -PART:
        return False
    return likeness**2 * free >= SIGNIFICANT**2 * (1.0 - likeness**2)


def _rows_or_points(recordings: Sequence[Recording]) -> tuple[np.ndarray, bool]:
    """Rows (n, ``_MOTION`` + 2) of the operating points if there are any, and whether; else those of all motions."""
    points = [_rows_of_points(r) for r in recordings if r.of_points]
    return (np.concatenate(points), True) if points else (_all_rows(recordings), False)


def _all_rows(recordings: Sequence[Recording]) -> np.ndarray:
    """Rows (n, ``_MOTION`` + 2) of all recordings that have both motion and load."""
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
    found = _alike(rows)
    return None if found is None else found[0]


def _alike(rows: np.ndarray) -> tuple[float, np.ndarray, np.ndarray] | None:
    """Correlation of load and drive torque, and both (n,), with the motion regressed out; None if one is nothing."""
    load, drive = (_beside(rows[:, :_MOTION], rows[:, column]) for column in (_MOTION, _MOTION + 1))
    both = float(np.linalg.norm(load) * np.linalg.norm(drive))
    return (float(load @ drive) / both, load, drive) if both > 0.0 else None


def _load_noise(recording: Recording) -> float:
    """Standard deviation of the load sensor's noise after smoothing."""
    load = recording.signals["load_torque"]
    return reading_noise(_whole(load)) * float(np.linalg.norm(_kernel(recording))) if np.isfinite(load).any() else 0.0


def _kernel(recording: Recording, derivative: int = 0) -> np.ndarray:
    return gaussian(_width(recording), 1.0, derivative)


def _width(recording: Recording) -> float:
    return max(_WIDTH, _SHARE * len(recording))


def _rows(recording: Recording) -> np.ndarray | None:
    """Rows (n, ``_MOTION`` + 2) of a recording, a kernel width apart; load and drive torque last. None without
    motion.
    """
    drive = recording.drive
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


def _rows_of_points(recording: Recording) -> np.ndarray:
    """Rows (n, ``_MOTION`` + 2) of operating points, which neither accelerate nor drift; none without drive torque."""
    drive = recording.drive
    if drive is None or not recording.has("load_torque"):
        return np.zeros((0, _MOTION + 2))
    load, torque = recording.signals["load_torque"], recording.signals[drive]
    none = np.zeros(len(load))
    speed = recording.signals.get("speed", none)
    rows = np.stack([none, speed, np.sign(speed), none + 1.0, none, load, torque], axis=1)
    known: np.ndarray = np.isfinite(rows).all(axis=1)
    return rows[known]


def _whole(values: np.ndarray) -> np.ndarray:
    """Values (n,) without transmission errors, missing ones interpolated."""
    known = np.isfinite(values)
    return despiked(np.interp(np.arange(len(values)), np.flatnonzero(known), values[known]))


def _beside(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Residual of values (n,) after regression on columns (n, k)."""
    size = np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
    found, *_ = np.linalg.lstsq(columns / size, values, rcond=None)
    left: np.ndarray = values - columns / size @ found
    return left
