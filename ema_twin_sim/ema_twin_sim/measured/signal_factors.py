"""Factors by which related signals of a recording are off, and the usual mistakes in an import map that cause them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ema_bench_replay.recording import Recording
from ema_bench_replay.units import signal_unit

from ..criteria import ALL_BUT_SPIKES, NEGLIGIBLE, PART, SMALL
from ..model import Model
from .twist import parts_by_angle
from .way_by_speed import lag_of, steady_factor, way_by_speed

DEGREES, RPM, TURN = 180.0 / math.pi, 60.0 / (2.0 * math.pi), 2.0 * math.pi


@dataclass(frozen=True)
class Relation:
    """How two related signals are compared; limits are relative."""

    off: float  # beyond this deviation they do not fit
    named: float  # within this distance a factor counts as a usual mistake
    beyond: float  # beyond this any factor is a mistake: no machine does that
    counted: bool  # whether encoder counts or the gear ratio may cause a factor


WAY_AND_SPEED = Relation(off=SMALL, named=NEGLIGIBLE, beyond=SMALL, counted=True)
# backlash and compliance take a part
TWO_SHAFTS = Relation(off=PART, named=NEGLIGIBLE, beyond=math.sqrt(PART), counted=True)
SETPOINT = Relation(off=0.5, named=SMALL, beyond=math.inf, counted=False)  # a drive follows late, or not at all


class Factor(NamedTuple):
    """``signal`` is ``value`` times what ``other`` implies."""

    signal: str
    other: str
    value: float
    relation: Relation

    def turned(self) -> Factor:
        """The same the other way round."""
        return Factor(self.other, self.signal, 1.0 / self.value, self.relation)


def wrong_factors(recording: Recording, model: Model, beside: Sequence[Recording]) -> list[Factor]:
    """The factors that mean a mistake in the import map; ``beside`` are recordings of the same machine."""
    return [factor for factor in _factors(recording, model) if _is_wrong(factor, recording, model, beside)]


def _is_wrong(factor: Factor, recording: Recording, model: Model, beside: Sequence[Recording]) -> bool:
    deviation = abs(factor.value - 1.0)
    if deviation > factor.relation.off and usual_mistake(factor, model):
        return True
    if factor.relation is not TWO_SHAFTS:
        return deviation > factor.relation.beyond
    return (
        deviation > SMALL
        and not _ratio_is_right(recording, model, beside)
        and (deviation > factor.relation.beyond or parts_by_angle(recording, model))
    )


def fits_elsewhere(factor: Factor, recording: Recording, model: Model, beside: Sequence[Recording]) -> bool:
    """Whether most recordings ``beside`` this one have the same signals in proportion: then no unit is wrong."""
    others = (other for another in beside if another is not recording for other in _factors(another, model))
    alike = [other for other in others if other[:2] == factor[:2]]
    fitting = [other for other in alike if abs(other.value - 1.0) <= other.relation.off]
    return 2 * len(fitting) > len(alike)


def _ratio_is_right(recording: Recording, model: Model, beside: Sequence[Recording]) -> bool:
    """Whether both shafts travel equally far from end to end in any recording, or in proportion in another one.

    Then an output that swings wider in this recording is on a compliant shaft.
    """
    return any(_goes_as_far(another, model) for another in (recording, *beside)) or any(
        abs(other.value - 1.0) <= SMALL
        for another in beside
        if another is not recording
        for other in _factors(another, model)
        if other.relation is TWO_SHAFTS
    )


def _factors(recording: Recording, model: Model) -> Iterator[Factor]:
    """The factors between all related signals that have a steady ratio."""
    signals = recording.signals
    lag = lag_of(recording)

    def way(name: str) -> np.ndarray:
        return signals[name][lag:] - signals[name][:-lag]

    def told(signal: str, other: str, values: np.ndarray, expected: np.ndarray, relation: Relation) -> Iterator[Factor]:
        value = steady_factor(values, expected)
        if value is not None:
            yield Factor(signal, other, value, relation)

    if (times := way_by_speed(recording)) is not None:
        yield Factor("motor_position", "speed", times, WAY_AND_SPEED)
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


def _as_thousandths(signal: str, model: Model) -> str:
    unit = signal_unit(signal, model.motion)
    return f"as if {signal} were in m{unit} and read as {unit}"


def usual_mistake(factor: Factor, model: Model) -> str:
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
        (1000.0, _as_thousandths(signal, model)),
        (0.001, _as_thousandths(other, model) + (", or the time in ms and read as s" if timed else "")),
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
