"""Whether a drive does nothing: its current is its noise, and nothing of it goes with the motion."""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import CORRELATION, DEPENDS, NOISY
from ..model import Model
from ..plant.motion import MOTOR_ANGLE, SPEED
from ..reading_noise import polled_noise
from .drive_regression import pieces_in_motion
from .observation import Observation
from .way_by_speed import FEWEST


def idle_current(recording: Recording, model: Model) -> tuple[float, float] | None:
    """(rms, noise) [A] of a current that does nothing, in the machine's own units; None if it does, or is not known.

    Its mean counts: at constant speed it is the friction. A drive may also do less than its noise, or something too
    fast for the noise to be told from it; then inertia, friction and loads explain more of its torque than chance. A
    measured load may drive the machine, and the current then tells something even if it is zero.
    """
    if recording.of_points or not recording.has("current") or recording.has("load_torque"):
        return None
    current = recording.signals["current"]
    current = current[np.isfinite(current)]
    size, noise = math.sqrt(float(np.mean(current**2))), polled_noise(current)
    if not 0.0 < size <= NOISY * noise:
        return None
    gains = [_gain(seen, model) for _, seen in pieces_in_motion(recording, model) if len(seen.rows) >= FEWEST]
    return (size, noise) if gains and max(gains) <= DEPENDS else None


def _gain(seen: Observation, model: Model) -> float:
    """Twice the log-likelihood ratio by which inertia, friction and loads explain the torque beside a constant."""
    speed, place = (seen.motion[seen.rows, column] for column in (SPEED, MOTOR_ANGLE))
    angle = place / model.value("machine.gear_ratio")
    columns = np.stack(
        [np.ones(len(speed)), seen.acceleration, np.sign(speed), speed, place, np.sin(angle), np.cos(angle)], axis=1
    )
    columns /= np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    left = seen.torque - columns @ np.linalg.lstsq(columns, seen.torque, rcond=None)[0]
    alone = float(np.sum((seen.torque - seen.torque.mean()) ** 2))
    left_power = float(left @ left)
    return len(speed) / CORRELATION * math.log(alone / left_power) if left_power > 0.0 else math.inf
