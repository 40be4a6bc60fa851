"""Ripple of a switching drive in a sampled current: neither sensor noise nor a missing effect.

The drive's comparators switch several thousand times a second, at moments that follow the electrical angle. A trace
with a period of some milliseconds samples what the acquisition filter leaves of it, and aliases it: at a slow steady
speed into oscillations as slow as those of an effect, which repeat with the motor angle. Third differences of the
current, from which other noise is estimated, hardly show it. The model of the drive determines how large it is: the
simulated current as the trace samples it, minus the same current sampled many times as often, both through the kernel
of the diagnosis.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording

from ..model import Model
from ..plant.motion import LOAD, MOTOR_ANGLE, MOTOR_CURRENT, SPEED
from ..simulation.simulate import simulate
from .observation import Observation
from .smoothing import gaussian, smooth

_FINER = 16
"""Oversampling relative to the trace: every control cycle of 125 us for a trace of 2 ms."""


def with_switching_ripple(o: Observation, model: Model) -> Observation:
    """An observation whose torque noise includes the ripple of a switching drive; unchanged for other drives.

    Raises InputError if the model's DC link cannot drive the recorded motion.
    """
    if model.kinds["drive"] != "switching" or o.of_points or not len(o.rows):
        return o
    constant = model.value("machine.torque_constant")
    sensor = constant * model.value("sensors.current_noise") * float(np.linalg.norm(o.kernel))
    return replace(o, torque_noise=np.maximum(o.torque_noise, math.hypot(sensor, constant * _folded(o, model))))


def _folded(o: Observation, model: Model) -> float:
    """RMS [A] over an observation's rows of what sampling aliases into the smoothed current."""
    ticks = np.arange((len(o.motion) - 1) * _FINER + 1)
    stamps = np.round(ticks * (o.period / _FINER * 1e9)).astype(np.int64)
    signals = {
        name: np.interp(ticks / _FINER, np.arange(len(o.motion)), o.motion[:, column])
        for name, column in (
            ("current", MOTOR_CURRENT),
            ("speed", SPEED),
            ("speed_setpoint", SPEED),
            ("motor_position", MOTOR_ANGLE),
            ("load_torque", LOAD),
        )
    }
    driven = Recording(
        name=o.name,
        stamps=stamps,
        signals=signals,
        motor_angle_origin=o.motor_origin,
        output_angle_origin=o.output_origin,
    )
    current = simulate(model, driven, "setpoint").signals["current"]
    # width of the kernel from its second moment
    places = np.arange(len(o.kernel)) - len(o.kernel) // 2
    width = o.period * math.sqrt(float(o.kernel @ places**2))
    whole = smooth(current, gaussian(width, o.period / _FINER))[::_FINER]
    difference = (smooth(current[::_FINER], o.kernel) - whole)[o.rows]
    return float(np.sqrt(np.mean((difference - difference.mean()) ** 2)))
