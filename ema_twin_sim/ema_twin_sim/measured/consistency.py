"""Consistency: whether a recording's signals fit each other and the model's inertia, before anything is fitted.

No effect makes a shaft turn by a multiple of its speed. A factor between two signals means a wrong unit, count, sign or
gear ratio in the import map; the usual mistakes are recognised by their size.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import ALL_BUT_SPIKES, NEGLIGIBLE, NOISY, PART, SMALL, TOO_MUCH
from ..effects import Trait, effects_with
from ..model import Model
from ..model.matching import BY_TORQUE
from ..model.own_units import shown
from ..plant.measured_motion import LOAD, MOTOR_ANGLE, SPEED
from ..quantities import quantity
from ..reading_noise import reading_noise
from ..simulation.angle_origins import origins_of
from ..simulation.assembly import assemble
from ..simulation.required import required_torque
from .load_sensor import falls_with_load
from .observation import Observation, observe
from .smoothing import smooth_at
from .twist import parts_by_angle
from .way_by_speed import FEWEST, lag_of, standing_position, steady_factor, way_by_speed

PIECE = 300.0  # own s that are judged at once: more takes memory and adds nothing

_ALSO = {
    frozenset({"output_position", "motor_position"}): ", and machine.gear_ratio (with {ratio:.4g} they fit)",
    frozenset({"motor_position", "speed"}): ", and the time; or remove the line of the one that the trace has wrong",
}
"""What else may be wrong if two signals do not fit."""

DEGREES, RPM, TURN = 180.0 / math.pi, 60.0 / (2.0 * math.pi), 2.0 * math.pi


@dataclass(frozen=True)
class _Relation:
    """How two related signals are compared; limits are relative."""

    off: float  # beyond this deviation they do not fit
    named: float  # within this distance a factor counts as a usual mistake
    beyond: float  # beyond this any factor is a mistake: no machine does that
    counted: bool  # whether encoder counts or the gear ratio may cause a factor


WAY_AND_SPEED = _Relation(off=SMALL, named=NEGLIGIBLE, beyond=SMALL, counted=True)
# backlash and compliance take a part
TWO_SHAFTS = _Relation(off=PART, named=NEGLIGIBLE, beyond=math.sqrt(PART), counted=True)
SETPOINT = _Relation(off=0.5, named=SMALL, beyond=math.inf, counted=False)  # a drive follows late, or not at all


class _Factor(NamedTuple):
    """``signal`` is ``value`` times what ``other`` implies."""

    signal: str
    other: str
    value: float
    relation: _Relation

    def turned(self) -> _Factor:
        return _Factor(self.other, self.signal, 1.0 / self.value, self.relation)


@dataclass(frozen=True)
class Inconsistency:
    """One signal that does not fit another, in words; ``remedy`` says what to check.

    ``kind`` is the same for the same mistake in another recording, ``times`` the factor by which it is off here.
    """

    recording: str
    what: str
    remedy: str
    kind: str
    times: float = 1.0

    def __str__(self) -> str:
        return f"{self.recording}: {self.what}; {self.remedy}"


def told_once(found: Iterable[Inconsistency], count: int) -> list[str]:
    """One line for each kind of mistake in ``count`` recordings: how many have it, and the worst of them."""
    kinds: dict[str, list[Inconsistency]] = {}
    for each in found:
        kinds.setdefault(each.kind, []).append(each)
    return [_with_number(alike, count) for alike in kinds.values()]


def _with_number(alike: Sequence[Inconsistency], count: int) -> str:
    worst = max(alike, key=lambda each: abs(math.log(abs(each.times))))
    return f"{len(alike)} of {count} recordings, the worst is {worst}" if len(alike) > 1 else str(worst)


def refuse_inconsistent(recordings: Sequence[Recording], model: Model) -> None:
    """Raise InputError with the first signal that does not fit the others."""
    for recording in recordings:
        for found in inconsistencies(recording, model, recordings):
            raise InputError(str(found))


def inconsistencies(recording: Recording, model: Model, beside: Sequence[Recording] = ()) -> Iterator[Inconsistency]:
    """What does not fit, the clearest first. Recording and model are in the machine's own units.

    ``beside`` are recordings of the same machine. If both shafts move in proportion in one of these, or travel equally
    far from end to end in any, the gear ratio is right: then an output that swings wider here is on a compliant shaft.
    """
    if recording.of_points:
        yield from _by_load(recording)
        return

    def swings(factor: _Factor) -> bool:
        return factor.relation is TWO_SHAFTS and (
            any(_goes_as_far(another, model) for another in (recording, *beside))
            or any(
                abs(other.value - 1.0) <= SMALL
                for another in beside
                if another is not recording
                for other in _factors(another, model)
                if other.relation is TWO_SHAFTS
            )
        )

    off = [
        factor
        for factor in _factors(recording, model)
        if (
            abs(factor.value - 1.0) > factor.relation.off
            and (_mistake(factor, model) or (abs(factor.value - 1.0) > factor.relation.beyond and not swings(factor)))
        )
        or (
            factor.relation is TWO_SHAFTS
            and abs(factor.value - 1.0) > SMALL
            and not swings(factor)
            and parts_by_angle(recording, model)
        )
    ]
    named = [name for factor in off for name in factor[:2]]
    for found in off:
        # if a signal fits neither of two others, that signal is wrong
        factor = found.turned() if named.count(found.other) > named.count(found.signal) else found
        pair, mistake = {factor.signal, factor.other}, _mistake(factor, model)
        yield Inconsistency(
            recording.name,
            f"{factor.signal} is {factor.value:.3g} times what {factor.other} makes it{mistake}",
            "check unit, factor and counts of both in the import map"
            + _ALSO.get(frozenset(pair), "").format(ratio=model.value("machine.gear_ratio") / abs(found.value)),
            f"{factor.signal} {factor.other}{mistake}",
            factor.value,
        )
    yield from _by_standing(recording, model)
    yield from _by_load(recording)
    yield from _by_limit(recording, model)
    yield from _by_noise(recording, model, beside)
    yield from _by_inertia(recording, model)


def _factors(recording: Recording, model: Model) -> Iterator[_Factor]:
    """The factors between all related signals that have a steady ratio."""
    signals = recording.signals
    lag = lag_of(recording)

    def way(name: str) -> np.ndarray:
        return signals[name][lag:] - signals[name][:-lag]

    def told(
        signal: str, other: str, values: np.ndarray, expected: np.ndarray, relation: _Relation
    ) -> Iterator[_Factor]:
        value = steady_factor(values, expected)
        if value is not None:
            yield _Factor(signal, other, value, relation)

    if (times := way_by_speed(recording)) is not None:
        yield _Factor("motor_position", "speed", times, WAY_AND_SPEED)
    if recording.has("output_position", "motor_position"):
        expected = way("motor_position") / model.value("machine.gear_ratio")
        yield from told("output_position", "motor_position", way("output_position"), expected, TWO_SHAFTS)
    for setpoint, name in (("speed_setpoint", "speed"), ("current_setpoint", "current")):
        if recording.has(setpoint, name):
            yield from told(setpoint, name, signals[setpoint], signals[name], SETPOINT)
    if recording.has("output_command", "output_position"):
        expected = way("output_position")
        yield from told("output_command", "output_position", way("output_command"), expected, SETPOINT)


def is_usual_mistake(times: float) -> bool:
    """Whether a factor between displacement and speed is one that units cause."""
    sizes = (size for unit in (DEGREES, RPM, TURN, 1000.0) for size in (unit, 1.0 / unit))
    return any(abs(abs(times) - size) <= WAY_AND_SPEED.named * size for size in sizes)


def _goes_as_far(recording: Recording, model: Model) -> bool:
    """Whether the output travels as far, from end to end, as the motor and gear ratio imply."""
    if not recording.has("output_position", "motor_position") or recording.of_points:
        return False
    spans = []
    for name in ("output_position", "motor_position"):
        low, high = np.nanquantile(recording.signals[name], (1.0 - ALL_BUT_SPIKES, ALL_BUT_SPIKES))
        spans.append(float(high - low))
    return abs(spans[0] * model.value("machine.gear_ratio") - spans[1]) <= SMALL * spans[1]


def _mistake(factor: _Factor, model: Model) -> str:
    """The usual cause of a factor, in words; empty if it is none of these."""
    signal, other, value, relation = factor
    ratio = model.value("machine.gear_ratio")
    timed = (signal, other) == ("motor_position", "speed")
    usual = [
        (DEGREES, f"as if {signal} were in degrees and read as radians"),
        (1.0 / DEGREES, f"as if {other} were in degrees and read as radians"),
        (RPM, f"as if {signal} were in rpm and read as rad/s"),
        (1.0 / RPM, f"as if {other} were in rpm and read as rad/s"),
        (TURN, f"as if {other} were in revolutions and read as radians"),
        (1.0 / TURN, f"as if {signal} were in revolutions and read as radians"),
        (1000.0, f"as if {signal} were in thousandths (mA, mrad)"),
        (
            0.001,
            f"as if {other} were in thousandths (mA, mrad)" + (", or the time in ms and read as s" if timed else ""),
        ),
    ]
    if relation.counted:
        counts = f"as if the counts_per_revolution of {signal} were"
        usual += [
            (4.0, f"{counts} its lines without their fourfold evaluation"),
            (0.25, f"{counts} taken times four twice"),
            (2.0, "as if one of them counted twice"),
            (0.5, "as if one of them counted half"),
        ]
        if ratio != 1.0:
            usual.append((ratio, f"the gear ratio: as if {signal} were of the other shaft"))
            usual.append((1.0 / ratio, f"one over the gear ratio: as if {signal} were of the other shaft"))
    for size, words in usual:
        if abs(abs(value) - size) <= relation.named * size:
            return f", {words}" + (", and of the other sign" if value < 0.0 else "")
    return ", of the other sign" if abs(value + 1.0) <= relation.named else ""


def _by_standing(recording: Recording, model: Model) -> Iterator[Inconsistency]:
    """Whether the position follows the speed at all."""
    way = standing_position(recording)
    if way is not None:
        turned = quantity(*shown(model, way, "rad"))
        yield Inconsistency(
            recording.name,
            f"motor_position stands still, while by the speed the motor moves by {turned}",
            "remove the line of motor_position from the import map, so that the speed is integrated instead; or, if "
            "the speed is wrong, remove that",
            "standing position",
        )


def _by_load(recording: Recording) -> Iterator[Inconsistency]:
    """Whether the drive's torque holds the measured load instead of yielding to it."""
    if falls_with_load([recording]):
        yield Inconsistency(
            recording.name,
            "the drive's torque falls where load_torque rises, as if the load's sign were turned round",
            "check the sign of load_torque and of current in the import map (`factor: -1` turns one)",
            "sign of the load",
        )


def _by_limit(recording: Recording, model: Model) -> Iterator[Inconsistency]:
    """Whether the current stays within what the drive can give."""
    limit = model.value("drive.current_limit")
    if recording.has("current") and BY_TORQUE not in recording.metadata:
        largest = float(np.nanquantile(np.abs(recording.signals["current"]), ALL_BUT_SPIKES))
        if largest > TOO_MUCH * limit:
            reached, allowed = (quantity(*shown(model, value, "A")) for value in (largest, limit))
            yield Inconsistency(
                recording.name,
                f"current reaches {reached} where the model's drive is limited to {allowed}, as if current were in mA "
                "and read as A",
                "check unit and factor of current in the import map, and drive.current_limit",
                "limit of the current",
                largest / limit,
            )


def _by_noise(recording: Recording, model: Model, beside: Sequence[Recording]) -> Iterator[Inconsistency]:
    """Whether all of the drive's current or torque is less than the noise that the model states.

    At a standstill there may be none: so it counts only if it is as small in all recordings ``beside`` this one.
    """
    share = _share_of_noise(recording, model)
    if not 0.0 < share * NOISY < 1.0 or any(_share_of_noise(other, model) * NOISY >= 1.0 for other in beside):
        return
    noise, name, unit = model.value("sensors.current_noise"), "current", "A"
    if BY_TORQUE in recording.metadata:
        noise, name, unit = noise * model.value("machine.torque_constant"), "motor_torque", "N m"
    whole, stated = (quantity(*shown(model, value, unit)) for value in (share * noise, noise))
    yield Inconsistency(
        recording.name,
        f"{name} is {whole} (rms) in all, less than the {stated} of noise that the model file states, so that the "
        "noise would hide whatever is missing",
        f"check unit and factor of {name} in the import map, and sensors.current_noise in the model",
        "noise of the current",
        share,
    )


def _share_of_noise(recording: Recording, model: Model) -> float:
    """RMS of the current in units of the model's noise; 0 without a current or a noise.

    The mean counts: at constant speed it is the friction, and varies by the noise alone.
    """
    noise = model.value("sensors.current_noise")
    if not recording.has("current") or not noise > 0.0:
        return 0.0
    return math.sqrt(float(np.nanmean(recording.signals["current"] ** 2))) / noise


def _by_inertia(recording: Recording, model: Model) -> Iterator[Inconsistency]:
    """Whether the current accelerates the machine as its inertia and loads require, if these are known."""
    parts = [model.constants[f"machine.{part}_inertia"] for part in ("motor", "gearbox", "output")]
    if any(math.isinf(part.tolerance) for part in (*parts, model.constants["machine.torque_constant"])):
        yield from _by_friction(recording, model)
        return
    motor, output = origins_of(recording, model)  # unknown origins are zero for the whole recording, not for each piece
    recording = replace(recording, motor_angle_origin=motor, output_angle_origin=output)
    for start in PIECE * np.unique(recording.time // PIECE):
        factor = _times_inertia(recording, start, model, sum(part.value for part in parts))
        if factor is not None:
            break  # the first piece with an answer decides
    else:
        return
    usual = {
        1000.0: "as if current were in mA and read as A",
        1.0 / DEGREES: "as if the motion were in degrees",
        -1.0: "as if its sign were turned round",
    }
    why = next((text for times, text in usual.items() if abs(factor - times) <= PART * abs(times)), None)
    if why is None:  # a load or a disturbance can cause any factor
        return
    yield Inconsistency(
        recording.name,
        f"current is {factor:.3g} times what the model's inertia needs for the acceleration, {why}",
        "check unit, factor and sign of current and of the positions in the import map, and the model's inertias",
        f"inertia, {why}",
        factor,
    )


def _times_inertia(recording: Recording, start: float, model: Model, inertia: float) -> float | None:
    """Measured torque over what the inertia [kg m^2] needs, from ``start`` [s] on; None if unknown."""
    try:
        piece = recording.between(start, start + PIECE)
        seen = observe(piece, model)
    except InputError:
        return None  # whatever needs the motion will report this
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


def _by_friction(recording: Recording, model: Model) -> Iterator[Inconsistency]:
    """Whether the current works against inertia and friction, of whatever size, and not with them."""
    if -1 in _signs(recording, model):
        yield Inconsistency(
            recording.name,
            "the current pushes against inertia and friction, as if its sign were turned round",
            "check the sign of current and of the positions in the import map (`factor: -1` turns one)",
            "sign of the current",
        )


def sign_of_drive(recording: Recording, model: Model) -> int:
    """The sign of a recording's current or torque: 1 if it moves the machine as read, -1 if reversed, 0 if undecided.

    Recording and model are in the machine's own units.
    """
    return 0 if recording.of_points else next(filter(None, _signs(recording, model)), 0)


def _signs(recording: Recording, model: Model) -> Iterator[int]:
    """Yield the same of each piece of the recording that shows a motion."""
    ratio = model.value("machine.gear_ratio")
    for start in PIECE * np.unique(recording.time // PIECE):
        try:
            seen = observe(recording.between(start, start + PIECE), model)
        except InputError:
            continue  # whatever needs the motion will report this
        speed, place = (seen.motion[seen.rows, column] for column in (SPEED, MOTOR_ANGLE))
        loads = np.stack([np.ones(len(speed)), place, np.sin(place / ratio), np.cos(place / ratio)], axis=1)
        if recording.has("load_torque"):  # which may drive the machine
            loads = np.column_stack([loads, np.nan_to_num(seen.motion[seen.rows, LOAD])])
        needed = np.stack([seen.acceleration, np.sign(speed), speed], axis=1)
        if len(speed) < FEWEST:
            continue
        as_read, turned = (_least_beside(loads, needed, sign * seen.torque) for sign in (1.0, -1.0))
        yield -1 if turned < PART * as_read else int(as_read < PART * turned)


def _least_beside(free: np.ndarray, positive: np.ndarray, torque: np.ndarray) -> float:
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
