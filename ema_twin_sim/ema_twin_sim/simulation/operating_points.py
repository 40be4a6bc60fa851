"""Operating points: independent samples at which a machine rests, or turns at constant speed.

Examples: holding current over the angle, a friction curve at constant speeds, a dynamometer's sweep. Nothing is
integrated: at every point the model's torques are balanced with the drive's, and the twin gives the current it needs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..model import Model
from ..plant.motion import MOTION, MOTOR_ANGLE, MOTOR_CURRENT, SPEED
from ..reading_noise import reading_noise
from .assembly import assemble
from .required import required_torque, twin_of

HOLDING = 1e-6  # of the fastest point's speed, assigned to a point at rest: only its sign, the way of approach, acts
STILL = 1e-3  # share of the fastest point's speed: a slower shaft is at rest where the way it was approached is known
SURE = 4.0  # standard deviations of a reading that a move or a speed must exceed, so that its direction is known
KNOWN = 0.95  # share of the points whose direction must be known
FEWEST = 12  # minimum number of points
FAR = 0.01  # share of the position range: points farther apart were each approached separately

DIRECTED = "directed"
"""Key of a recording's metadata if its points at rest have a direction; the value says whether any point moves."""
_MOVING = "moving"


def motion_at_points(recording: Recording, model: Model) -> np.ndarray:
    """The motion (n, 7) with the columns MOTION; a point at rest has the direction of its approach.

    Raises InputError if the recording lacks the signals for it.
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
    columns = dict(
        time=recording.time,
        motor_angle=position,
        speed=directed(recording, model.value("sensors.speed_noise")).signals["speed"],
        acceleration=nothing,
        current=recording.signals["current"],
        output_angle=recording.signals.get("output_position", position / model.value("machine.gear_ratio")),
        load=recording.signals.get("load_torque", nothing),
    )
    return np.stack([columns[name] for name in MOTION], axis=1)


def directed(recording: Recording, noise: float = 0.0) -> Recording:
    """The recording with a speed: for a point at rest, a vanishing one in the direction of its approach.

    ``noise`` [rad/s] is that of the speed's readings. Where nothing tells the approach, a speed beyond its noise keeps
    its own direction, however slow it is: slow machines have no other.
    """
    if DIRECTED in recording.metadata:
        return recording
    nothing = np.zeros(len(recording))
    speed = recording.signals.get("speed", nothing)
    sizes = np.abs(speed)
    fastest = float(np.max(sizes[np.isfinite(sizes)], initial=0.0))
    known = sizes > SURE * noise
    moving = bool(known.any())
    resting = ~known & np.isfinite(sizes)
    if noise == 0.0:  # nothing says what a reading is worth
        resting |= sizes < STILL * fastest
    if resting.any():
        way = approached(recording.signals.get("motor_position", nothing))
        slow = HOLDING * (fastest if moving else 1.0)
        speed = np.where(resting & ((way != 0.0) | ~known), slow * way, speed)
    metadata = {**recording.metadata, DIRECTED: _MOVING if moving else "at rest"}
    return replace(recording, signals={**recording.signals, "speed": speed}, metadata=metadata)


def moves(recording: Recording, noise: float = 0.0) -> bool:
    """Whether a shaft turns at any of the points; ``noise`` [rad/s] is that of the speed's readings."""
    return directed(recording, noise).metadata[DIRECTED] == _MOVING


def approached(position: np.ndarray) -> np.ndarray:
    """The direction of approach (n,), -1 or 1, of each position in the order of the points; 0 if unknown.

    The sign of the step from the previous point if points are far apart; otherwise over as many points as noise needs.
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
    """The current that a model needs at each point, at the recorded positions and speeds."""
    motion = motion_at_points(recording, model)
    plant = assemble(model).plant[0]
    unpowered = motion.copy()
    unpowered[:, MOTOR_CURRENT] = 0.0
    without = _required(model, recording, unpowered)
    current = motion[:, MOTOR_CURRENT]
    more = _required(model, recording, motion) - without
    by_current = np.divide(more, current, out=np.zeros(len(current)), where=current != 0.0)
    angle = motion[:, MOTOR_ANGLE]
    signals = {
        "current": without / (plant["torque_constant"] - by_current),  # effects may be proportional to it
        "speed": motion[:, SPEED],
        "motor_position": angle,
        "output_position": angle / plant["gear_ratio"],
    }
    return twin_of(recording, model, signals)


def doubled(motion: np.ndarray) -> np.ndarray:
    """A motion (n, 7) with each point twice (2 n, 7): a row's transmitted torque is used by the next one."""
    return np.repeat(motion, 2, axis=0)


def _required(model: Model, recording: Recording, motion: np.ndarray) -> np.ndarray:
    """Torque [N m] (n,) that the model needs at each point of a motion (n, 7)."""
    return required_torque(assemble(model), recording, doubled(motion))[1::2]
