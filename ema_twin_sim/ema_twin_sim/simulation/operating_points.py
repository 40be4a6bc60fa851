"""Operating points: samples at which a machine rests, or turns at constant speed, each by itself.

A curve of holding current over the angle, a friction curve of constant speeds, a dynamometer's sweep. Nothing is
integrated: at every point the model's torques stand against the drive's, and the twin tells the current it would need.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..effects import catalogue
from ..model import Model
from ..plant.measured_motion import MOTION, MOTOR_ANGLE, MOTOR_CURRENT, REQUIRED, SPEED, require
from ..reading_noise import reading_noise
from .assembly import assemble

HOLDING = 0.05  # rad/s with which a point counts that was approached at no speed to speak of: its sign alone acts
STILL = HOLDING  # rad/s: a slower shaft rests, and its speed is its sensor's noise
SURE = 4.0  # standard deviations of a reading by which a shaft was moved, for the way it came to be known
KNOWN = 0.95  # share of the points of which that way shall be known
FEWEST = 12  # points that can be told anything from
FEWEST_OF_HALVES = 4 * FEWEST
BLOCKS = 8  # of the positions, every other of which is judged by the rest
FAR = 0.01  # of all positions' range: by so much from point to point, each was come to by a way of its own

SPEED_DEPENDENT = frozenset({"viscous_friction", "stribeck_friction", "quadratic_drag", "shear_thinning"})
"""Effects that do not show where nothing turns."""
PLACES = frozenset({"order", "output_position", "encoders"})
"""What an effect shows over that does not show where no position is known."""
TRANSIENT = frozenset({"added_inertia", "presliding_friction", "thermal_friction", "encoder_delay"})
"""Effects that no operating point shows: they take an acceleration, a way or a time."""
BY_CURRENT = frozenset({"torque_ripple", "torque_constant_error"})
"""Effects in proportion to the very current that is to be explained: they would explain any."""


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
    speed = recording.signals.get("speed", nothing)
    resting = np.abs(speed) < STILL
    if resting.any():
        speed = np.where(resting, HOLDING * approached(position), speed)
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
    without = required_at_points(model, recording, unpowered)
    current = motion[:, MOTOR_CURRENT]
    more = required_at_points(model, recording, motion) - without
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


def required_at_points(model: Model, recording: Recording, motion: np.ndarray) -> np.ndarray:
    """Torque [N m] (n,) that the model needs at each point of a motion (n, 7)."""
    assembly = assemble(model)
    motor, output = (
        origin if np.isfinite(origin) else 0.0
        for origin in (recording.motor_angle_origin, recording.output_angle_origin)
    )
    twice = np.repeat(motion, 2, axis=0)  # what a row transmits is known to the one after it
    required = np.empty((len(twice), len(REQUIRED)))
    require(assembly.plant, assembly.effects, twice, motor, output, np.zeros(0), False, required)
    return required[1::2, 0]


def not_shown(recordings: Sequence[Recording]) -> frozenset[str]:
    """Effects that recordings do not show, since all of them are of operating points."""
    if not all(recording.of_points for recording in recordings):
        return frozenset()
    hidden = {*TRANSIENT, *BY_CURRENT}
    speeds = [np.abs(r.signals["speed"]) for r in recordings if r.has("speed")]
    if not any(float(np.nanmax(speed)) >= STILL for speed in speeds):
        hidden |= SPEED_DEPENDENT
    positions = [r.signals["motor_position"] for r in recordings if r.has("motor_position")]
    if not any(float(np.nanmax(position) - np.nanmin(position)) > 0.0 for position in positions):
        hidden |= {id for id, effect in catalogue().items() if effect.depends_on in PLACES}
    return frozenset(hidden)


def refuse_mixed(recordings: Sequence[Recording]) -> None:
    """Raise InputError where operating points stand beside recordings of a motion: they are judged differently."""
    names = [recording.name for recording in recordings if recording.of_points]
    if names and len(names) < len(recordings):
        raise InputError(
            f"{', '.join(names)}: operating points, beside recordings of a motion; give one kind at a time, the second "
            "with the model that the first gave"
        )


def at_rest(model: Model, recordings: Sequence[Recording]) -> Model:
    """The model less what recordings of points at rest do not show, switched off; ``woken`` switches it on again."""
    hidden = not_shown(recordings)
    sleeping = {
        name: replace(instance, enabled=False) for name, instance in model.active.items() if instance.effect in hidden
    }
    return replace(model, effects={**model.effects, **sleeping}) if sleeping else model


def woken(found: Model, given: Model) -> Model:
    """A model with what is on in the one ``given`` switched on."""
    on = {name: replace(found.effects[name], enabled=True) for name in given.active if name in found.effects}
    return replace(found, effects={**found.effects, **on})


def halves(recordings: Sequence[Recording]) -> list[Recording]:
    """A lone recording of points as two, so that each can be judged by the other: every other eighth of its positions.

    Where all its positions are one, every other point. Others, and few points, stay as they are.
    """
    refuse_mixed(recordings)
    if len(recordings) != 1 or not recordings[0].of_points or len(recordings[0]) < FEWEST_OF_HALVES:
        return list(recordings)
    whole = recordings[0]
    position = whole.signals.get("motor_position")
    rank = np.arange(len(whole))
    if position is not None and np.nanmax(position) > np.nanmin(position):
        rank[np.argsort(position, kind="stable")] = np.arange(len(whole))
        odd, names = (rank * BLOCKS // len(whole)) % 2 == 0, ("odd eighths of the positions", "even eighths")
    else:
        odd, names = rank % 2 == 0, ("odd points", "even points")
    return [_part(whole, chosen, name) for chosen, name in zip((odd, ~odd), names, strict=True)]


def _part(whole: Recording, chosen: np.ndarray, name: str) -> Recording:
    stamps = whole.stamps[chosen]
    return replace(
        whole,
        name=f"{whole.name}, {name}",
        stamps=stamps - stamps[0],
        signals={key: values[chosen] for key, values in whole.signals.items()},
        start=whole.start + int(stamps[0]),
    )
