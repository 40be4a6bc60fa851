"""Whether two shafts differ because of compliance or backlash, or because of a wrong gear ratio.

Compliance and backlash follow the torque; a wrong gear ratio follows the angle alone.
"""

from __future__ import annotations

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import PART, SMALL
from ..model import Model
from .smoothing import gaussian, smooth, smooth_way

SMOOTHED = 10.0  # samples
FEWEST = 400  # samples
AT_ENDS = 40  # samples at each end that the smoothing distorts


def parts_by_angle(recording: Recording, model: Model) -> bool:
    """Whether the encoder difference follows the motor angle, without any torque that would cause it.

    The twist of a shaft is torque over stiffness, and backlash has the sign of the motion. So drive torque,
    acceleration, speed and its sign explain both. If the load follows the angle, as a spring's does, or the motion is a
    single sine, whose acceleration is proportional to the angle, both explanations fit and the answer is no.
    """
    if not recording.has("motor_position", "output_position", "current") or len(recording) < FEWEST:
        return False
    whole = np.isfinite([recording.signals[k] for k in ("motor_position", "output_position", "current")]).all(axis=0)
    if whole.sum() < FEWEST:
        return False
    time, samples = recording.time, np.flatnonzero(whole)
    motor, output, current = (
        np.interp(time, time[samples], recording.signals[name][samples])
        for name in ("motor_position", "output_position", "current")
    )
    turned = motor / model.value("machine.gear_ratio")
    apart = smooth_way(output - turned, gaussian(SMOOTHED, 1.0))
    speed, acceleration = (smooth_way(turned, gaussian(SMOOTHED, 1.0, order)) for order in (1, 2))
    torque = smooth(current, gaussian(SMOOTHED, 1.0))
    columns = np.stack([torque, acceleration, speed, np.sign(speed), turned], axis=1)
    moves = whole & (np.abs(speed) > SMALL * np.abs(speed).max())  # at rest the output may lie anywhere in its backlash
    moves[:AT_ENDS] = moves[-AT_ENDS:] = False
    if moves.sum() < FEWEST:
        return False
    columns, apart = columns[moves] - columns[moves].mean(axis=0), apart[moves] - apart[moves].mean()
    columns = columns / np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)

    def left(explained: np.ndarray) -> float:
        found = np.linalg.lstsq(explained, apart, rcond=None)[0]
        rest = apart - explained @ found
        return float(rest @ rest)

    parted = float(apart @ apart)
    by_angle = left(columns[:, -1:]) < SMALL * parted
    return by_angle and left(columns[:, :-1]) > PART**2 * parted
