"""The output behind a measured motor: the twin of a recording with two encoders and no torque.

The motor is not simulated: it moves as measured, and drives the output through the model's backlash, compliance or
encoder delay. Torques have an arbitrary unit, so only their ratios matter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording, spread

from ..effects import catalogue
from ..effects.catalogue import is_own
from ..model import Model, reference_bench
from ..model.own_units import OwnUnits, model_in, recording_in
from ..plant.measured_motion import REQUIRED, inverse_dynamics
from ..plant.motion import MOTION
from ..plant.output_side import LOW_SPEED
from ..plant.sensors import as_encoder_shows
from .angle_origins import origins_of
from .assembly import assemble
from .required import twin_of

WIDTH = 2.5  # samples over which the motor's counter is smoothed for its speed
MARGIN = 12  # samples; the smoothing does not reach farther


def of_encoders_alone(recording: Recording) -> bool:
    """Whether a recording holds the positions of motor and output, but no signal that drives a twin."""
    return (
        recording.has("motor_position", "output_position")
        and not recording.of_points
        and not any(recording.has(name) for name in ("current", "motor_torque", "speed_setpoint"))
    )


def refuse_encoders_alone(recording: Recording) -> None:
    """Raise InputError if a recording holds no signal that can drive a twin in real time."""
    if of_encoders_alone(recording):
        raise InputError(
            f"{recording.name}: holds no current, torque or setpoint, which drive a live twin; compare, fit and "
            "discover take recordings of two encoders alone"
        )


def encoder_units(recordings: Sequence[Recording], model: Model, radius: float | None = None) -> OwnUnits:
    """Own units of a machine recorded with both encoders and no torque; ``radius`` [m] as in ``typical_units``.

    SI if its model holds a user's own effect, whose function may hold numbers in SI.
    """
    if any(is_own(catalogue()[instance.effect]) for instance in model.active.values()):
        return OwnUnits(radius=radius)
    return typical_units(recordings, model, radius)


def typical_units(recordings: Sequence[Recording], model: Model, radius: float | None = None) -> OwnUnits:
    """Units in which a machine recorded without torque has the size of the reference bench: time from its speed.

    A machine too fast for its samples has a longer unit of time, in which these are as close as the bench's.

    The torque unit is arbitrary, chosen so that the model's inertia equals the reference's. ``radius`` [m] is that of
    the drum that represents a linear machine.
    """
    inertia = sum(model.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    motors = [_even(recording) for recording in spread(recordings)]
    square = float(np.mean([np.mean(np.gradient(position, time) ** 2) for time, position in motors]))
    if not (square > 0.0 and inertia > 0.0):
        return OwnUnits(radius=radius)
    drum = radius or 1.0
    period = max(float(time[1] - time[0]) for time, _ in motors)
    # a contact that rings many times between two samples takes long to simulate and shows nothing
    time = max(reference_bench.MOTOR_SPEED * drum / math.sqrt(square), period / reference_bench.LONGEST_PERIOD)
    time = min(time, period / reference_bench.SHORTEST_PERIOD)  # of a machine that hardly moves
    return OwnUnits(time, inertia * drum**2 / reference_bench.INERTIA / time**2, 1.0, radius)


def twin_behind_motor(model: Model, recording: Recording) -> Recording:
    """Both encoder readings of the model driven by the motor's measured motion, at the recording's stamps.

    The output is aligned in the mean, since its place in the backlash at the first sample is unknown. If the motor's
    position is missing, so is the output's. Raises InputError if no sample holds both positions.
    """
    from scipy.ndimage import gaussian_filter1d  # takes 0.2 s to import, and few recordings need it

    units = encoder_units([recording], model)  # own units, in which the resolution limits are known
    told, model = recording_in(recording, units), model_in(model, units)
    time, position = _even(told)
    period = float(time[1] - time[0])
    # extrapolate the motion beyond its ends
    going_on = np.pad(position, MARGIN, mode="reflect", reflect_type="odd")
    angle, speed = (gaussian_filter1d(going_on, WIDTH, order=order)[MARGIN:-MARGIN] for order in (0, 1))
    speed = speed / period
    columns = dict.fromkeys(MOTION, np.zeros(len(time)))
    columns |= {
        "time": time,
        "motor_angle": angle,
        "speed": speed,
        "acceleration": np.gradient(speed, period),
        "output_angle": position / model.value("machine.gear_ratio"),
    }
    if told.has("load_torque"):
        measured = np.isfinite(told.signals["load_torque"])
        columns["load"] = np.interp(time, told.time[measured], told.signals["load_torque"][measured])
    assembly = assemble(model)
    motor_origin, output_origin = origins_of(told, model)
    required = np.empty((len(time), len(REQUIRED)))
    motion = np.stack([columns[name] for name in MOTION], axis=1)
    inverse_dynamics(
        assembly.plant, assembly.effects, motion, motor_origin, output_origin, np.zeros(0), False, LOW_SPEED, required
    )
    moved = required[:, REQUIRED.index("output")] + (position - angle) / model.value("machine.gear_ratio")
    output = as_encoder_shows(assembly.plant[0], time, moved, output_origin)
    # the difference alone is interpolated; the output of a motor position that was not measured is not known either
    ratio = model.value("machine.gear_ratio")
    output = told.signals["motor_position"] / ratio + np.interp(told.time, time, output - position / ratio)
    if np.isnan(output - recording.signals["output_position"]).all():
        raise InputError(
            f"{recording.name}: has no sample that holds motor_position and output_position together; record both at "
            "the same instants"
        )
    output -= np.nanmean(output - recording.signals["output_position"])
    signals = {
        "motor_position": recording.signals["motor_position"],
        "output_position": output,
        "speed": np.interp(told.time, time, speed) / units.time,
    }
    return twin_of(recording, model, signals)


def _even(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """(time [s] on an even grid, motor position [rad] there); gaps are bridged by straight lines.

    Raises InputError if no position is known.
    """
    position = recording.signals["motor_position"]
    known = np.isfinite(position)
    if not known.any():
        raise InputError(
            f"{recording.name}: its motor_position holds no number; is the encoder connected, and is that the right "
            "column of the trace?"
        )
    # from the first sample to the last: stamps in own units are rounded to nanoseconds, and so is their period
    time = np.linspace(0.0, recording.duration, round(recording.duration / recording.sample_period) + 1)
    return time, np.interp(time, recording.time[known], position[known])
