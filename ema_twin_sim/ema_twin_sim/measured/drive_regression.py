"""Regression of the drive's torque on the measured motion: its sign, and its size relative to what inertia needs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import combinations

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import PART, SMALL
from ..effects import Trait, effects_with
from ..model import Model
from ..plant.motion import LOAD, MOTOR_ANGLE, MOTOR_CURRENT, SPEED
from ..reading_noise import reading_noise
from ..simulation.angle_origins import origins_of
from ..simulation.assembly import assemble
from ..simulation.required import required_torque
from .observation import Observation
from .observe import observe
from .smoothing import smooth_at
from .way_by_speed import FEWEST

PIECE = 300.0  # own s that are judged at once: more takes memory and adds nothing


def sign_of_drive(recording: Recording, model: Model) -> int:
    """The sign of a recording's current or torque: 1 if it moves the machine as read, -1 if reversed, 0 if undecided.

    It is undecided too if pieces of the recording tell opposite signs. Recording and model are in the machine's own
    units.
    """
    return 0 if recording.of_points else agreed_sign(signs_of_drive(recording, model))


def agreed_sign(signs: Iterable[int]) -> int:
    """The sign that several tell, of which 0 tells nothing; 0 if none tells one, or if two tell opposite ones."""
    told = set(signs) - {0}
    return told.pop() if len(told) == 1 else 0


def signs_of_drive(recording: Recording, model: Model) -> Iterator[int]:
    """The same of each piece of the recording that shows a motion.

    A sign is told by inertia and friction, so they must need a real share of the torque beside loads of any sign: in a
    steady motion these explain all but nearly nothing, and what is left of it has either sign by chance. Nor is a
    torque reversed that brings energy into the machine as it is read: a passive one takes energy in.
    """
    ratio = model.value("machine.gear_ratio")
    for _, seen in pieces_in_motion(recording, model):
        speed, place = (seen.motion[seen.rows, column] for column in (SPEED, MOTOR_ANGLE))
        loads = np.stack([np.ones(len(speed)), place, np.sin(place / ratio), np.cos(place / ratio)], axis=1)
        if recording.has("load_torque"):  # which may drive the machine
            loads = np.column_stack([loads, np.nan_to_num(seen.motion[seen.rows, LOAD])])
        needed = np.stack([seen.acceleration, np.sign(speed), speed], axis=1)
        if len(speed) < FEWEST:
            continue
        as_read, turned = (least_beside(loads, needed, sign * seen.torque) for sign in (1.0, -1.0))
        alone = least_beside(loads, needed[:, :0], seen.torque)
        if alone - min(as_read, turned) < SMALL**2 * float(seen.torque @ seen.torque):
            yield 0
        elif turned < PART * as_read:
            yield 0 if brings_energy(recording, seen) else -1
        else:
            yield int(as_read < PART * turned)


def brings_energy(recording: Recording, seen: Observation) -> bool:
    """Whether the drive as read brings far more energy into the machine than it takes out; False beside a load sensor,
    which may show another machine that drives this one.
    """
    power = seen.motion[:, MOTOR_CURRENT] * seen.motion[:, SPEED]
    return not recording.has("load_torque") and float(power.sum()) > PART * float(np.abs(power).sum())


def least_beside(free: np.ndarray, positive: np.ndarray, torque: np.ndarray) -> float:
    """Least squared residual of a torque (m,), with columns (m, k) of any sign and others that must not be negative."""
    columns = np.hstack([positive, free])
    size = np.linalg.norm(columns, axis=0)
    columns = columns / np.where(size > 0.0, size, 1.0)
    products, shares = columns.T @ columns, columns.T @ torque
    signed = positive.shape[1]
    others = list(range(signed, columns.shape[1]))
    least = math.inf
    for count in range(signed + 1):
        for chosen in combinations(range(signed), count):
            places = [*chosen, *others]
            found, *_ = np.linalg.lstsq(products[np.ix_(places, places)], shares[places], rcond=None)
            if (found[:count] >= 0.0).all():
                least = min(least, float(torque @ torque - shares[places] @ found))
    return max(least, 0.0)


def torque_over_inertia(recording: Recording, model: Model) -> float | None:
    """Measured torque over what the model's inertia and loads need; None if no piece of the recording tells."""
    motor, output = origins_of(recording, model)  # unknown origins are zero for the whole recording, not for each piece
    recording = replace(recording, motor_angle_origin=motor, output_angle_origin=output)
    factors = (_over_inertia(piece, seen, model) for piece, seen in pieces_in_motion(recording, model))
    return next((factor for factor in factors if factor is not None), None)


def _over_inertia(piece: Recording, seen: Observation, model: Model) -> float | None:
    """The same of one piece."""
    inertia = sum(model.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    speed = seen.motion[seen.rows, SPEED]
    needed = inertia * seen.acceleration + _load(piece, model, seen)
    columns = np.stack([needed, np.sign(speed), speed, np.ones(len(speed))], axis=1)
    size = np.linalg.norm(columns, axis=0)
    if len(speed) < FEWEST or not size.all():
        return None
    if reading_noise(seen.acceleration) > PART * float(np.std(seen.acceleration)):
        return None
    found, *_ = np.linalg.lstsq(columns / size, seen.torque, rcond=None)
    left = seen.torque - columns / size @ found
    without = columns[:, 1:] / size[1:]
    rest = seen.torque - without @ np.linalg.lstsq(without, seen.torque, rcond=None)[0]
    if float(left @ left) > SMALL * float(rest @ rest):
        return None
    factor = float(found[0] / size[0])
    return factor if found[1] * factor >= 0.0 else None  # a missing spring does not reverse friction


def _load(recording: Recording, model: Model, seen: Observation) -> np.ndarray:
    """Torque [N m] (m,) of the model's loads, and of a measured one; zero if its gearbox can separate."""
    loads = effects_with(Trait.LOAD)
    effects = {name: instance for name, instance in model.active.items() if instance.effect in loads}
    assembly = assemble(replace(model, effects=effects))
    load = np.zeros(len(seen.rows))
    if assembly.plant[0]["two_inertia"] == 0.0:
        needed = np.ascontiguousarray(required_torque(assembly, recording, seen.motion))
        smooth_at(needed, seen.kernel, seen.rows, load)
    return load


def pieces_in_motion(recording: Recording, model: Model) -> Iterator[tuple[Recording, Observation]]:
    """The pieces of a recording that show a motion under a drive that changes, and what is observed in them."""
    for start in PIECE * np.unique(recording.time // PIECE):
        piece = recording.between(start, start + PIECE)
        if piece.has("current") and np.ptp(piece.signals["current"]) == 0.0:  # a constant load explains all of it
            continue
        with suppress(InputError):  # whatever needs the motion will report this
            yield piece, observe(piece, model)
