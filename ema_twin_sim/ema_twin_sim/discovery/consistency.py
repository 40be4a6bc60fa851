"""Consistency: whether a recording's signals fit each other, and the model's inertia, before anything is fitted.

No effect makes a shaft turn by a multiple of its speed. A factor between two signals is a unit, a count, a sign or a
gear ratio that is wrong in the import map; the usual ones are known by their size.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..model import Model
from ..model.matching import BY_TORQUE
from ..plant.measured_motion import SPEED
from ..reading_noise import reading_noise
from .observation import observe

WINDOW = 0.1  # s over which ways are compared
MOVING = 0.3  # of the largest: less of a signal tells no factor
FEWEST = 30  # samples that do
STEADY = 0.1  # spread of a factor, relative, from which on it is none
NAMED = 0.03  # relative, within which a factor is a usual mistake
NAMED_SETPOINT = 0.15  # the same of a setpoint, which its signal follows late
OFF = 0.1  # relative, beyond which the ways of one shaft do not fit its speed
OFF_SHAFTS = 0.25  # the same of two shafts: play and springs take something away
OFF_SETPOINT = 0.5  # the same of a controller, which may follow badly
NAMED_INERTIA = 0.25
LEFT = 0.1  # of what friction leaves of the torque, in power: where an acceleration leaves more, it is not in charge
OVER_LIMIT = 3.0  # times the drive's limit
ALL_BUT_SPIKES = 0.999  # quantile of a current that is its largest
NOISY = 0.3  # of an acceleration: with more noise in it, a slope to it tells nothing

DEGREES, RPM, TURN = 180.0 / math.pi, 60.0 / (2.0 * math.pi), 2.0 * math.pi


@dataclass(frozen=True)
class Inconsistency:
    """One signal that does not fit another, in words; ``remedy`` is what to look at."""

    recording: str
    what: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.recording}: {self.what}; {self.remedy}"


def refuse_inconsistent(recordings: Sequence[Recording], model: Model) -> None:
    """Raise InputError with the first signal that does not fit the others."""
    for recording in recordings:
        for found in inconsistencies(recording, model):
            raise InputError(str(found))


def inconsistencies(recording: Recording, model: Model) -> Iterator[Inconsistency]:
    """What does not fit, the plainest first. The recording is matched to the model, which is of a rotary machine."""
    if recording.of_points:
        return
    off = []
    for signal, other, factor, allowed in _factors(recording, model):
        # only a shaft's way and its own speed can be off by nothing but a mistake
        if abs(factor - 1.0) > allowed and (allowed == OFF or _mistake(signal, other, factor, model)):
            off.append((signal, other, factor))
    named = [name for signal, other, _ in off for name in (signal, other)]
    for signal, other, factor in off:
        if named.count(other) > named.count(signal):  # what fits none of two others is what is wrong
            signal, other, factor = other, signal, 1.0 / factor
        yield Inconsistency(
            recording.name,
            f"{signal} is {factor:.3g} times what {other} makes it{_mistake(signal, other, factor, model)}",
            f"check unit, factor and counts of {signal} and {other} in the import map"
            + (", and machine.gear_ratio" if {signal, other} == {"output_position", "motor_position"} else ""),
        )
    yield from _by_limit(recording, model)
    yield from _by_inertia(recording, model)


def _factors(recording: Recording, model: Model) -> Iterator[tuple[str, str, float, float]]:
    """(signal, the other that it should fit, factor between them, how far that may be from one)."""
    signals = recording.signals
    lag = max(1, round(WINDOW / recording.sample_period)) if len(recording) > 1 else 1
    ratio = model.value("machine.gear_ratio")

    def way(name: str) -> np.ndarray:
        return signals[name][lag:] - signals[name][:-lag]

    if recording.has("speed", "motor_position"):
        known = np.isfinite(signals["speed"])
        if not known.any():
            return
        speed = np.interp(recording.time, recording.time[known], signals["speed"][known])
        travelled = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(recording.time))])
        yield from _factor("motor_position", "speed", way("motor_position"), travelled[lag:] - travelled[:-lag], OFF)
    if recording.has("output_position", "motor_position"):
        expected = way("motor_position") / ratio
        yield from _factor("output_position", "motor_position", way("output_position"), expected, OFF_SHAFTS)
    for setpoint, name in (("speed_setpoint", "speed"), ("current_setpoint", "current")):
        if recording.has(setpoint, name):
            yield from _factor(setpoint, name, signals[setpoint], signals[name], OFF_SETPOINT)
    if recording.has("output_command", "output_position"):
        yield from _factor(
            "output_command", "output_position", way("output_command"), way("output_position"), OFF_SETPOINT
        )


def _factor(
    signal: str, other: str, values: np.ndarray, expected: np.ndarray, allowed: float
) -> Iterator[tuple[str, str, float, float]]:
    both = np.isfinite(values) & np.isfinite(expected)
    values, expected = values[both], expected[both]
    large = np.abs(expected) > MOVING * np.abs(expected).max(initial=0.0)
    if large.sum() < FEWEST:
        return
    ratios = values[large] / expected[large]
    middle = float(np.median(ratios))
    if middle != 0.0 and 1.4826 * float(np.median(np.abs(ratios - middle))) < STEADY * abs(middle):
        yield signal, other, middle, allowed


def _mistake(signal: str, other: str, factor: float, model: Model) -> str:
    """What a factor is usually the sign of, in words; empty where it is none of these."""
    ratio = model.value("machine.gear_ratio")
    usual = [
        (DEGREES, f"as if {signal} were in degrees and read as radians"),
        (1.0 / DEGREES, f"as if {other} were in degrees and read as radians"),
        (RPM, f"as if {signal} were in rpm and read as rad/s"),
        (1.0 / RPM, f"as if {other} were in rpm and read as rad/s"),
        (TURN, f"as if {other} were in revolutions and read as radians"),
        (1.0 / TURN, f"as if {signal} were in revolutions and read as radians"),
        (1000.0, f"as if {signal} were in thousandths (mA, mrad)"),
        (0.001, f"as if {other} were in thousandths (mA, mrad)"),
    ]
    # a drive that saturates stays behind its setpoint by any factor: of these no count is told
    if not {signal, other} & {"speed_setpoint", "current_setpoint", "output_command"}:
        usual += [
            (
                4.0,
                f"as if the counts_per_revolution of {signal} were those before the fourfold evaluation of its lines",
            ),
            (0.25, f"as if the counts_per_revolution of {signal} were taken times four twice"),
            (2.0, "as if one of them counted twice"),
            (0.5, "as if one of them counted half"),
        ]
        if ratio != 1.0:
            usual.append((ratio, f"the gear ratio: as if {signal} were of the other shaft"))
            usual.append((1.0 / ratio, f"one over the gear ratio: as if {signal} were of the other shaft"))
        near = NAMED
    else:
        near = NAMED_SETPOINT
    for size, words in usual:
        if abs(abs(factor) - size) <= near * size:
            return f", {words}" + (", and of the other sign" if factor < 0.0 else "")
    return ", of the other sign" if abs(factor + 1.0) <= near else ""


def _by_limit(recording: Recording, model: Model) -> Iterator[Inconsistency]:
    """Whether the current stays within what the drive can give."""
    limit = model.value("drive.current_limit")
    if recording.has("current") and BY_TORQUE not in recording.metadata:
        largest = float(np.nanquantile(np.abs(recording.signals["current"]), ALL_BUT_SPIKES))
        if largest > OVER_LIMIT * limit:
            yield Inconsistency(
                recording.name,
                f"current reaches {largest:.3g} A where the model's drive is limited to {limit:.3g} A, as if current "
                "were in mA and read as A",
                "check unit and factor of current in the import map, and drive.current_limit",
            )


def _by_inertia(recording: Recording, model: Model) -> Iterator[Inconsistency]:
    """Whether the current accelerates the machine as its inertia lets it, where that is known."""
    parts = [model.constants[f"machine.{part}_inertia"] for part in ("motor", "gearbox", "output")]
    if any(math.isinf(part.tolerance) for part in (*parts, model.constants["machine.torque_constant"])):
        return
    try:
        seen = observe(recording, model)
    except InputError:
        return  # whoever needs the motion will say so
    speed = seen.motion[seen.rows, SPEED]
    columns = np.stack([seen.acceleration, np.sign(speed), speed, np.ones(len(speed))], axis=1)
    size = np.linalg.norm(columns, axis=0)
    if len(speed) < FEWEST or not size.all():
        return
    if reading_noise(seen.acceleration) > NOISY * float(np.std(seen.acceleration)):
        return
    found, *_ = np.linalg.lstsq(columns / size, seen.torque, rcond=None)
    left = seen.torque - columns / size @ found
    without = columns[:, 1:] / size[1:]
    rest = seen.torque - without @ np.linalg.lstsq(without, seen.torque, rcond=None)[0]
    if float(left @ left) > LEFT * float(rest @ rest):
        return
    factor = float(found[0] / size[0]) / sum(part.value for part in parts)
    usual = {1000.0: "current were in mA and read as A", 1.0 / DEGREES: "the motion were in degrees", -1.0: "its sign"}
    if found[1] * factor < 0.0:  # a spring may turn the sign round, but not friction's
        return
    words = [text for times, text in usual.items() if abs(factor - times) <= NAMED_INERTIA * abs(times)]
    if not words:  # what a load or a disturbance makes of it has any size
        return
    why = ", as if " + words[0] + (" were turned round" if factor < 0.0 else "")
    yield Inconsistency(
        recording.name,
        f"current is {factor:.3g} times what the model's inertia needs for the acceleration{why}",
        "check unit, factor and sign of current and of the positions in the import map, and the model's inertias",
    )
