"""Consistency: whether a recording's signals fit each other and the model's inertia, before anything is fitted.

No effect makes a shaft turn by a multiple of its speed. A factor between two signals means a wrong unit, count, sign or
gear ratio in the import map; the usual mistakes are recognised by their size.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..criteria import ALL_BUT_SPIKES, NOISY, PART, TOO_MUCH
from ..model import Model
from ..model.matching import BY_TORQUE
from ..model.model_file import TORQUE_CONSTANT
from ..model.own_units import shown
from ..quantities import quantity
from .drive_in_words import drive_in_words
from .drive_regression import sign_of_drive, torque_over_inertia
from .idle_drive import idle_current
from .induced_voltage import BUS, impossible_voltage
from .load_sensor import falls_with_load
from .signal_factors import DEGREES, fits_elsewhere, usual_mistake, wrong_factors
from .unjudgeable import RIGHT_COLUMN
from .unknown_inertia import of_unknown_inertia
from .way_by_speed import standing_position

_ALSO = {
    frozenset({"output_position", "motor_position"}): ", and machine.gear_ratio (with {ratio:.4g} they fit)",
    frozenset({"motor_position", "speed"}): ", and the time; or remove the line of the one that the trace has wrong",
}
"""What else may be wrong if two signals do not fit."""


@dataclass(frozen=True)
class Inconsistency:
    """One signal that does not fit another, in words; ``remedy`` says what to check.

    ``kind`` is the same for the same mistake in another recording, ``times`` the factor by which it is off here. What
    is not ``certain`` is a question, and stops nothing.
    """

    recording: str
    what: str
    remedy: str
    kind: str
    times: float = 1.0
    certain: bool = True

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


def refuse_inconsistent(recordings: Sequence[Recording], model: Model) -> tuple[str, ...]:
    """Raise InputError with the first signal that does not fit the others; returns what is only doubtful."""
    doubts = []
    for recording in recordings:
        for found in inconsistencies(recording, model, recordings):
            if found.certain:
                raise InputError(str(found))
            doubts.append(found)
    return tuple(told_once(doubts, len(recordings)))


def inconsistencies(recording: Recording, model: Model, beside: Sequence[Recording] = ()) -> Iterator[Inconsistency]:
    """What does not fit, the clearest first. Recording and model are in the machine's own units.

    ``beside`` are recordings of the same machine.
    """
    if recording.of_points:
        yield from _by_load(recording)
        yield from _by_voltage(recording, model)
        return
    yield from _by_factor(recording, model, beside)
    yield from _by_standing(recording, model)
    yield from _by_load(recording)
    yield from _by_limit(recording, model)
    yield from _by_noise(recording, model, beside)
    yield from _by_zero_drive(recording, model, beside)
    yield from _by_idle_drive(recording, model, beside)
    yield from _by_inertia(recording, model, beside)
    yield from _by_voltage(recording, model)


def _by_factor(recording: Recording, model: Model, beside: Sequence[Recording]) -> Iterator[Inconsistency]:
    """Whether related signals are in proportion as their units, counts and the gear ratio imply."""
    off = wrong_factors(recording, model, beside)
    named = [name for factor in off for name in factor[:2]]
    for found in off:
        # if a signal fits neither of two others, that signal is wrong
        factor = found.turned() if named.count(found.other) > named.count(found.signal) else found
        pair, mistake = {factor.signal, factor.other}, usual_mistake(factor, model)
        certain = bool(mistake) or not fits_elsewhere(found, recording, model, beside)
        remedy = "check unit, factor and counts of both in the import map" + _ALSO.get(frozenset(pair), "").format(
            ratio=model.value("machine.gear_ratio") / abs(found.value)
        )
        yield Inconsistency(
            recording.name,
            f"{factor.signal} is {_times(factor.value)} what {factor.other} makes it{mistake}",
            remedy if certain else "in most other recordings they fit: does one of them drift or slip here?",
            f"{factor.signal} {factor.other}{mistake}",
            factor.value,
            certain=certain,
        )


def _times(factor: float) -> str:
    """``57.3 times``, ``1000 times``: three digits, without an exponent up to a million."""
    return f"{float(f'{factor:.3g}'):g} times"


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
    noise = model.value("sensors.current_noise")
    name, whole, stated = drive_in_words(recording, model, share * noise, noise)
    yield Inconsistency(
        recording.name,
        f"{name} is {whole} (rms) in all, less than the {stated} of noise that the model file states, so that the "
        "noise would hide whatever is missing",
        f"check unit and factor of {name} in the import map, and sensors.current_noise in the model (if init drafted "
        "both with a wrong unit, correct the unit in the column's name and run init again)",
        "noise of the current",
        share,
    )


def _by_zero_drive(recording: Recording, model: Model, beside: Sequence[Recording]) -> Iterator[Inconsistency]:
    """Whether a current is zero in every sample of all recordings, and no measured load drives the machine instead.

    Beside others, such a recording is of a machine that runs down.
    """
    if not recording.has("current") or any(map(_is_driven, (recording, *beside))):
        return
    name, zero = drive_in_words(recording, model, 0.0)
    yield Inconsistency(recording.name, f"its {name} is {zero} all along", RIGHT_COLUMN, "zero drive", certain=False)


def _is_driven(recording: Recording) -> bool:
    return recording.has("load_torque") or (recording.has("current") and bool(np.any(recording.signals["current"])))


def _by_idle_drive(recording: Recording, model: Model, beside: Sequence[Recording]) -> Iterator[Inconsistency]:
    """Whether the drive does anything, in this recording or in one ``beside`` it, on a machine of unknown inertia.

    Something else may drive it, and then its current has nothing to say; or it may coast, and then inertia and friction
    are known from each other alone.
    """
    idle = idle_current(recording, model) if of_unknown_inertia(model) else None
    if idle is None or any(idle_current(other, model) is None for other in beside if other is not recording):
        return
    name, whole, noise = drive_in_words(recording, model, *idle)
    yield Inconsistency(
        recording.name,
        f"the drive does nothing here: its {name} is {whole} (rms), its noise {noise}, and nothing of it goes with the "
        "motion",
        "record with the drive on, or check the import map; a torque from outside is its load_torque",
        "idle drive",
    )


def _share_of_noise(recording: Recording, model: Model) -> float:
    """RMS of the current in units of the model's noise; 0 without a current or a noise.

    The mean counts: at constant speed it is the friction, and varies by the noise alone.
    """
    noise = model.value("sensors.current_noise")
    if not recording.has("current") or not noise > 0.0:
        return 0.0
    return math.sqrt(float(np.nanmean(recording.signals["current"] ** 2))) / noise


def _by_inertia(recording: Recording, model: Model, beside: Sequence[Recording]) -> Iterator[Inconsistency]:
    """Whether the current accelerates the machine as its inertia and loads require, if these are known."""
    if of_unknown_inertia(model):
        yield from _by_friction(recording, model, beside)
        return
    factor = torque_over_inertia(recording, model)
    if factor is None:
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
        f"current is {_times(factor)} what the model's inertia needs for the acceleration, {why}",
        "check unit, factor and sign of current and of the positions in the import map, and the model's inertias",
        f"inertia, {why}",
        factor,
    )


def _by_friction(recording: Recording, model: Model, beside: Sequence[Recording]) -> Iterator[Inconsistency]:
    """Whether the current works against inertia and friction, of whatever size, and not with them.

    One map reads all recordings ``beside`` this one, so if any of them tells the other sign, this is a question.
    """
    if sign_of_drive(recording, model) >= 0:
        return
    other = next(
        (other.name for other in beside if other.name != recording.name and sign_of_drive(other, model) > 0), None
    )
    yield Inconsistency(
        recording.name,
        "the current pushes against inertia and friction, as if its sign were turned round"
        + (f", but not in {other}" if other else ""),
        "check the sign of current and of the positions in the import map (`factor: -1` turns one)"
        + (", and whether both were recorded alike" if other else ""),
        "sign of the current",
        certain=other is None,
    )


def _by_voltage(recording: Recording, model: Model) -> Iterator[Inconsistency]:
    """Whether a motor with the model's torque constant could turn as fast as recorded, on a machine of unknown inertia.

    A question, since volts are no scale of a machine: of one with known inertia the current tells more.
    """
    voltage = impossible_voltage(recording, model) if of_unknown_inertia(model) else None
    if voltage is not None:
        constant = quantity(*shown(model, model.value(TORQUE_CONSTANT), "N m/A"))
        yield Inconsistency(
            recording.name,
            f"a motor of {constant} would induce {quantity(voltage, 'V')} at its recorded speed, where a drive has "
            f"{BUS:g} V",
            f"check unit and shaft of {TORQUE_CONSTANT} in the model, and the unit of the motion in the import map",
            "induced voltage",
            voltage / BUS,
            certain=False,
        )
