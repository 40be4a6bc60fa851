"""Scales of a machine: the units of time, torque, current and length in which it fits the criteria.

In own units every machine has the inertia, the typical torque and the torque constant of the bench of the Politecnico
di Torino, on which the criteria were calibrated. The unit of torque follows from the rms drive torque. The unit of time
is the time in which that torque turns the inertia by about a radian, sqrt(J / T); of machines whose operating points
alone are known, which accelerate no inertia, it follows from the rms speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import joined_if_short, overlapping, pieces, quantile
from ema_bench_replay.recording import Recording

from ..criteria import ALL_BUT_SPIKES, NEARLY_ALL, SMALL, STANDSTILL
from ..effects import catalogue, find_effect
from ..effects.catalogue import is_own, own_files
from ..model import Model, reference_bench
from ..model.own_units import OwnUnits, model_in, recording_in
from ..model.roles import COMPLIANT_EFFECTS, DRY_FRICTION, FRICTION
from ..simulation.behind_motor import encoder_units, of_encoders_alone, typical_units
from ..simulation.operating_points import moves
from ..simulation.simulate import POINTWISE
from .balance_estimate import estimate_balance
from .quieter_motion import as_measured

INERTIAS = ("machine.motor_inertia", "machine.gearbox_inertia", "machine.output_inertia")


def to_rotary_equivalent(recordings: Sequence[Recording], model: Model) -> tuple[list[Recording], Model]:
    """Recordings and model as a twin needs them: matched and in SI; a linear machine as an equivalent drum.

    Raises InputError if they do not belong together.
    """
    found = as_measured(recordings, model)
    if model.motion == "rotary":
        return found, model
    units = OwnUnits(radius=drum_radius(found))
    return [recording_in(recording, units) for recording in found], model_in(model, units)


def to_own_units(recordings: Sequence[Recording], model: Model) -> tuple[list[Recording], Model]:
    """Recordings and model as a search needs them: matched, and in the machine's own units.

    Raises InputError if they do not belong together.
    """
    found = as_measured(recordings, model)
    begun = begun_near(found, model)
    units = own_units(found, begun)
    try:
        return [recording_in(recording, units) for recording in found], model_in(begun, units)
    except ValueError:  # its samples would be less than a nanosecond apart
        raise InputError(
            f"{found[0].name}: beside its motion, its torque or current is of no machine's size; check the units and "
            "factors of current, torque and positions in the import map"
        ) from None


def begun_near(recordings: Sequence[Recording], model: Model, *, absent: bool = False) -> Model:
    """The model with its open inertia and friction set close to what the recordings show.

    Open values are guesses: neither a scale nor an answer may depend on them. Friction that the recordings do not show
    keeps its guess, since a search needs a start; with ``absent`` it is zero.
    """
    paths = [path for path in INERTIAS if model.value(path) > 0.0]
    if not model.is_open or not all(math.isinf(model.constants[path].tolerance) for path in paths):
        return model
    torque = rms_torque(recordings, model)
    estimate = estimate_balance(recordings, model, torque) if torque > 0.0 else None
    if estimate is None:
        return model
    factor = estimate.inertia / sum(model.value(path) for path in paths)
    constants = {path: model.constants[path].at(factor * model.value(path)) for path in paths}
    effects = dict(model.effects)
    for id, size in zip(FRICTION, (estimate.viscous, estimate.coulomb), strict=True):
        held = {name: effect for name, effect in model.active.items() if effect.effect == id}
        parameter = find_effect(id, id).parameters[0].name
        total = sum(effect.parameters[parameter] for effect in held.values())
        if held and (size > 0.0 or absent) and total > 0.0 and all(effect.open for effect in held.values()):
            for name, effect in held.items():
                parameters = {**effect.parameters, parameter: effect.parameters[parameter] * size / total}
                effects[name] = effect.at(parameters)
    return replace(model, constants={**model.constants, **constants}, effects=effects)


def own_units(recordings: Sequence[Recording], model: Model) -> OwnUnits:
    """Units in which a machine has the size of the reference bench; SI if its equations contain numbers of their own.

    These are machines with simulated wheels or phases, and users' own effects, whose functions may contain numbers in
    SI.
    """
    radius = drum_radius(recordings) if model.motion == "linear" else None
    torque = rms_torque(recordings, model) * (radius or 1.0)
    inertia = sum(model.value(path) for path in INERTIAS) * (radius or 1.0) ** 2
    if recordings and all(map(of_encoders_alone, recordings)):
        own = any(is_own(effect) and effect.depends_on == "encoders" for effect in catalogue().values())
        return OwnUnits(radius=radius) if own else encoder_units(recordings, model, radius)
    fine = model.kinds["drive"] == "switching" or model.kinds["transmission"] == "planetary"
    if fine or own_files() or not (torque > 0.0 and inertia > 0.0):
        return OwnUnits(radius=radius)
    size = torque / reference_bench.TORQUE
    time = math.sqrt((inertia / reference_bench.INERTIA) / size)
    if steady := [r for r in recordings if r.of_points and moves(r, model.value("sensors.speed_noise"))]:
        rms_speed = float(np.sqrt(np.mean(np.concatenate([*_speeds(steady)]) ** 2)))
        time = reference_bench.MOTOR_SPEED / rms_speed * (radius or 1.0)  # nothing accelerates an inertia
    elif all(math.isinf(model.constants[path].tolerance) for path in INERTIAS if model.value(path) > 0.0):
        time = _quick_enough(recordings, time, radius)
    constant = model.value("machine.torque_constant") * (radius or 1.0)
    return OwnUnits(time, size, size * reference_bench.TORQUE_CONSTANT / constant, radius)


def standstill(recordings: Sequence[Recording], model: Model, source: str) -> float:
    """Motor speed [rad/s; of the drum for a linear machine] below which its direction means little.

    ``source`` is the input that drives the twin: each operating point has a direction, however slow it is.
    """
    if source == POINTWISE:
        return 0.0  # a point at rest has the direction of its approach
    found = as_measured(recordings, model)
    return STANDSTILL / own_units(found, begun_near(found, model)).time


def _quick_enough(recordings: Sequence[Recording], time: float, radius: float | None) -> float:
    """Unit of time [s] in which a machine moves noticeably.

    If its inertia is unknown, and it moves so slowly that it would count as standing still much of the time, its speed
    sets the unit of time. A torsion test is such a motion, and so is that of a joint whose data refer to the joint
    side.
    """
    fastest = quantile(lambda: (speeds / (radius or 1.0) for speeds in _speeds(recordings)), NEARLY_ALL)
    return max(time, STANDSTILL / (SMALL * fastest)) if fastest > 0.0 else time


def with_output_held(model: Model, recordings: Sequence[Recording]) -> Model:
    """Model in own units with enough open friction for its output to come to rest when nothing pushes it.

    This is for recordings without torque data, where the friction is unknown but an output behind backlash needs it. A
    model with backlash or compliance already has the friction that was found with these.
    """
    parted = any(effect.effect in COMPLIANT_EFFECTS for effect in model.active.values())
    if parted or not (recordings and all(map(of_encoders_alone, recordings))):
        return model
    held = {
        name: effect
        for name, effect in model.active.items()
        if effect.effect == DRY_FRICTION and effect.open and effect.options.get("side") == "output"
    }
    # if own units are SI here, the machine's size must be taken into account
    torque = reference_bench.OUTPUT_FRICTION * typical_units(recordings, model).factor("N m") / max(len(held), 1)
    rough = {name: effect.at({**effect.parameters, "torque": torque}) for name, effect in held.items()}
    return replace(model, effects={**model.effects, **rough})


def with_hidden_as_given(found: Model, given: Model, recordings: Sequence[Recording]) -> Model:
    """The native model ``found``, with what two encoders without torque data cannot show taken from ``given``.

    Without backlash or compliance they show no friction. With it they show the output's friction, and of the constants
    only the tooth contact, which was taken as stiff as the samples can resolve.
    """
    if not (recordings and all(map(of_encoders_alone, recordings))):
        return found
    if any(effect.effect in COMPLIANT_EFFECTS for effect in found.active.values()):
        told = "not known; as stiff as the samples of two encoders tell"
        constants = {
            path: held if held.value == given.value(path) else replace(held, source=told)
            for path, held in found.constants.items()
        }
        return replace(found, constants=constants)
    hidden = {name: given.effects[name] for name in found.effects if name in given.effects}
    return replace(found, constants=given.constants, effects={**found.effects, **hidden})


def rms_torque(recordings: Sequence[Recording], model: Model) -> float:
    """Rms drive torque [N m; N for a linear machine] over all recordings; 0 if none has one."""
    parts = joined_if_short(
        lambda: _sizes(recording.signals["current"] for recording in recordings if recording.has("current"))
    )
    count = sum(map(len, parts()))
    if not count:
        return 0.0
    largest = quantile(parts, ALL_BUT_SPIKES)
    square = sum(np.sum(np.minimum(sizes, largest) ** 2) for sizes in parts()) / count
    return float(model.value("machine.torque_constant") * np.sqrt(square))


def drum_radius(recordings: Sequence[Recording]) -> float:
    """Radius [m] of a drum that turns at usual speeds for a linear machine's recordings."""
    fastest = quantile(lambda: _speeds(recordings), NEARLY_ALL)
    return 10.0 ** round(math.log10(fastest / reference_bench.DRUM_SPEED)) if fastest > 0.0 else 1.0


def _speeds(recordings: Sequence[Recording]) -> Iterator[np.ndarray]:
    """Absolute values (m,) of all speeds [m/s]: measured, or from the motor position if samples are in time order."""
    for recording in recordings:
        if recording.has("speed"):
            yield from _sizes([recording.signals["speed"]])
        elif recording.has("motor_position") and not recording.of_points:
            for way, time in zip(*map(overlapping, (recording.signals["motor_position"], recording.time)), strict=True):
                yield from _sizes([np.diff(way) / np.diff(time)])


def _sizes(columns: Iterable[np.ndarray]) -> Iterator[np.ndarray]:
    """Finite absolute values of columns (n,), piece by piece."""
    for column in columns:
        for rows in pieces(len(column)):
            sizes = np.abs(column[rows])
            yield sizes[np.isfinite(sizes)]
