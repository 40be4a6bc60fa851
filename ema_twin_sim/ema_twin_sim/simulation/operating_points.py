"""Operating points: samples at which a machine rests, or turns at constant speed, each by itself.

A curve of holding current over the angle, a friction curve of constant speeds, a dynamometer's sweep. Nothing is
integrated: at every point the model's torques stand against the drive's, and the twin tells the current it would need.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..model import Model
from ..plant.measured_motion import MOTION, MOTOR_ANGLE, MOTOR_CURRENT, SPEED
from ..reading_noise import reading_noise
from .assembly import assemble
from .required import required_torque

HOLDING = 0.05  # rad/s with which a point counts that was approached at no speed to speak of: its sign alone acts
STILL = 0.04  # rad/s: a slower shaft rests, and its speed is its sensor's noise
SURE = 4.0  # standard deviations of a reading by which a shaft was moved, for the way it came to be known
KNOWN = 0.95  # share of the points of which that way shall be known
FEWEST = 12  # points that can be told anything from
FAR = 0.01  # of all positions' range: by so much from point to point, each was come to by a way of its own


def motion_at_points(recording: Recording, model: Model) -> np.ndarray:
    """The motion (n, 7) with the columns MOTION; a point at rest has the direction in which it was approached.

    Raises InputError where the recording lacks what that takes.
    """
    if not recording.has("current") or not (recording.has("motor_position") or recording.has("speed")):
        raise InputError(
            f"{recording.name}: operating points need current and motor_position or speed; "
            f"it holds {', '.join(recording.signals)}"
        )
    if assemble(model).plant[0]["two_inertia"] != 0.0:
        raise InputError(
            f"model {model.name}: has play or a spring in its gearbox, of which {recording.name} (operating points) "
            "tells nothing; remove it (ema-twin remove), or give recordings of a motion"
        )
    nothing = np.zeros(len(recording))
    position = recording.signals.get("motor_position", nothing)
    speed = directed(recording).signals["speed"]
    output = recording.signals.get("output_position", position / model.value("machine.gear_ratio"))
    load = recording.signals.get("load_torque", nothing)
    columns = dict(
        time=recording.time,
        motor_angle=position,
        speed=speed,
        acceleration=nothing,
        current=recording.signals["current"],
        output_angle=output,
        load=load,
    )
    return np.stack([columns[name] for name in MOTION], axis=1)


def directed(recording: Recording) -> Recording:
    """The recording with a speed: where a point rests, ``HOLDING`` in the direction in which it was come to."""
    nothing = np.zeros(len(recording))
    speed = recording.signals.get("speed", nothing)
    resting = np.abs(speed) < STILL
    if resting.any():
        speed = np.where(resting, HOLDING * approached(recording.signals.get("motor_position", nothing)), speed)
    return replace(recording, signals={**recording.signals, "speed": speed})


def approached(position: np.ndarray) -> np.ndarray:
    """The direction (n,), -1 or 1, in which each position was come to in the order of the points; 0 where unknown.

    From one point to the next where they lie far apart; else, where readings shake by more than a step, over several.
    """
    whole = np.isfinite(position)
    if not whole.all():
        direction = np.zeros(len(position))
        if whole.any():
            direction[whole] = approached(position[whole])
        return direction
    steps = np.diff(position, prepend=position[:1])
    if len(position) > 2 and float(np.median(np.abs(steps[1:]))) > FAR * float(np.ptp(position)):
        return np.sign(steps)
    reading = reading_noise(position)
    direction = np.zeros(len(position))
    reach = 1
    while reach <= max(1, len(position) // 8):
        ahead = np.concatenate([position[reach:], np.full(reach, position[-1])])
        behind = np.concatenate([np.full(reach, position[0]), position[:-reach]])
        way = ahead - behind
        direction = np.where(np.abs(way) > max(SURE * reading, 1e-12), np.sign(way), 0.0)
        if np.mean(direction != 0.0) >= KNOWN:
            break
        reach *= 2
    return direction


def twin_at_points(model: Model, recording: Recording) -> Recording:
    """The current that a model needs at each point, at the recording's own positions and speeds."""
    motion = motion_at_points(recording, model)
    plant = assemble(model).plant[0]
    unpowered = motion.copy()
    unpowered[:, MOTOR_CURRENT] = 0.0
    without = _required(model, recording, unpowered)
    current = motion[:, MOTOR_CURRENT]
    more = _required(model, recording, motion) - without
    by_current = np.divide(more, current, out=np.zeros(len(current)), where=current != 0.0)
    angle = motion[:, MOTOR_ANGLE]
    return replace(
        recording,
        signals={
            "current": without / (plant["torque_constant"] - by_current),  # effects may ask in proportion to it
            "speed": motion[:, SPEED],
            "motor_position": angle,
            "output_position": angle / plant["gear_ratio"],
        },
        metadata={"model": model.name},
        warnings=(),
    )


def doubled(motion: np.ndarray) -> np.ndarray:
    """A motion (n, 7) with each point twice (2 n, 7): what a row transmits is known to the one after it."""
    return np.repeat(motion, 2, axis=0)


def _required(model: Model, recording: Recording, motion: np.ndarray) -> np.ndarray:
    """Torque [N m] (n,) that the model needs at each point of a motion (n, 7)."""
    return required_torque(assemble(model), recording, doubled(motion))[1::2]
