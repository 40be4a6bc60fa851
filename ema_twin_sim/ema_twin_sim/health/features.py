"""Manipulation: reduce the samples of a run to a few features with a unit, each changed by one kind of damage.

==================  =================================================================================================
feature             what it is
==================  =================================================================================================
friction            mean effort against the motion, over both directions, while moving steadily
load                half the difference of the effort between the directions
rest_effort         mean effort at rest: what holds the load, and the offset of a supply current
roughness           scatter in steady motion about the waves, of effort and position (geometric mean)
fast_roughness      the same from sample to sample
slow_roughness      the same of means over a few samples: stick-slip, hunting while moving
rest_hunting        scatter at rest: a control loop that hunts across play
wave_*              phasor of the wave that repeats with the position, as a share of the effort of that direction
wave_depth          size of that wave in both directions (root of the mean square), in % of the effort
wave_both_ways      part of that wave at the same place in both directions: it helps one way and hinders the other
bump                largest local excess of the effort over a stroke, relative to the scatter of that effort
lag                 mean error of the position while starting
breakaway           largest effort while starting, minus the steady one
settling            mean effort while the motion settles after a stroke
lost_motion         half of how much the distance between two encoders differs between the directions
encoder_reach       half of how much that distance differs over the whole run
encoder_scatter     scatter of that distance within a steady stroke
encoder_drift       scatter of that distance between strokes of one direction
freed_wave_*        the waves again, without what errors of the position explain (``disturbance``)
==================  =================================================================================================

Scatters and lags are logarithms of their size in the given unit: a ratio to the healthy unit is then a difference. No
scatter is less than that of rounding to the smallest step of the sensor. Scatters, bumps and lost motion are means over
strokes or rests, each of which counts once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..criteria import MOSTLY
from .disturbance import disturbance
from .encoders import encoders_apart
from .motion_record import MotionRecord, rounding_scatter
from .phases import Phases, Piece, phases_of
from .wave import FEWEST_CYCLES, beside_wave, wave_phasor

_FEW = 5  # samples that are averaged to show slow scatter
_PEAK = 3  # largest samples that are averaged to a peak
_LOCAL = 3  # samples that are averaged to a local excess
_FREED = "freed_"
_TINY = 1e-9  # of the travel or of the effort, so that no scatter is zero


class Feature(NamedTuple):
    """One number of a run."""

    value: float  # in the unit; if a logarithm, of the size in that unit
    unit: str
    logarithm: bool = False
    of_effort: bool = True  # whether it needs the effort

    @property
    def scales(self) -> bool:
        """Whether it is compared after dividing by the unit's own effort."""
        return self.of_effort and not self.logarithm and self.unit not in ("1", "%")


@dataclass(frozen=True)
class Features:
    """All features of a run, by name."""

    values: dict[str, Feature]
    sides: tuple[float, float]  # effort against the motion, forward and backward, in the effort's unit

    def told(self, freed: bool) -> dict[str, Feature]:
        """Each feature once: the waves unchanged, or (``freed``) without what errors of the position explain."""
        plain = {name: value for name, value in self.values.items() if not name.startswith(_FREED)}
        if not freed:
            return plain
        return {name: self.values.get(_FREED + name, value) for name, value in plain.items()}


def features_of(record: MotionRecord, wavelength: float, unsigned: bool) -> Features:
    """The features of a run. ``wavelength``, in the position's unit, may be NaN: then no wave is fitted."""
    phases = phases_of(record)
    found: dict[str, Feature] = {}
    forward, backward = (level(record, phases, side, unsigned) for side in (1, -1))
    unit, place = record.effort_unit, record.position_unit
    known = [side for side in (forward, backward) if np.isfinite(side)]
    found["friction"] = Feature(float(np.mean(known)), unit)
    if len(known) == 2:
        found["load"] = Feature(0.5 * (forward - backward), unit)
    if phases.strokes(0):
        found["rest_effort"] = Feature(_mean(record.effort, phases.strokes(0)), unit)
    found |= _scatter(record, phases, wavelength, unsigned)
    if np.isfinite(wavelength):
        for freed, prefix in ((False, ""), (True, _FREED)):
            waves = _waves(record, phases, wavelength, unsigned, freed)
            found |= {prefix + name: wave for name, wave in waves.items()}
    error = record.position if record.command is None else record.command - record.position
    strokes = phases.strokes(1) + phases.strokes(-1)
    if record.command is not None:
        moved = np.concatenate([np.abs(error[p.beginning]) for p in strokes])
        found["lag"] = _log(float(moved.mean()), phases.travel, place, of_effort=False)
    starts = [
        _peak(_along(record.effort, p, unsigned)[p.beginning]) for p in strokes if p.beginning.stop > p.beginning.start
    ]
    steady = [float(_along(record.effort, p, unsigned)[p.steady].mean()) for p in strokes]
    if len(starts) == len(steady):
        found["breakaway"] = Feature(float(np.mean(np.subtract(starts, steady))), unit)
    if rests := phases.strokes(0):
        found["settling"] = Feature(float(np.mean([np.abs(record.effort[p.beginning]).mean() for p in rests])), unit)
    if record.motor_position is not None and len(known) == 2:
        apart = encoders_apart(record, phases)
        found["lost_motion"] = Feature(apart.lost_motion, place, of_effort=False)
        for name, size in (
            ("encoder_reach", apart.reach), ("encoder_scatter", apart.scatter), ("encoder_drift", apart.drift)
        ):  # fmt: skip
            if size is not None:
                found[name] = _log(size, phases.travel, place, of_effort=False)
    return Features(found, (forward, backward))


def level(record: MotionRecord, phases: Phases, direction: int, unsigned: bool) -> float:
    """Mean effort against the motion while moving steadily one way; NaN if the run never does."""
    pieces = phases.strokes(direction)
    return _mean(_along(record.effort, pieces[0], unsigned), pieces) if pieces else np.nan


def _waves(record: MotionRecord, phases: Phases, wavelength: float, unsigned: bool, freed: bool) -> dict[str, Feature]:
    """The features of the wave, unchanged or (``freed``) without what errors of the position explain.

    Empty for strokes that are too short to show it.
    """
    found: dict[str, float] = {}
    for direction, name in ((1, "forward"), (-1, "backward")):
        strokes = [(p, np.r_[p.steady]) for p in phases.strokes(direction)]
        size = _size(record, phases, direction, unsigned)
        if (wave := _phasor(record, strokes, size, wavelength, unsigned, freed)) is not None:
            found |= {f"wave_{name}_cos": wave.real, f"wave_{name}_sin": wave.imag}
    if not found:
        return {}
    depth = 100.0 * float(np.sqrt(2.0 * np.mean(np.square(list(found.values())))))
    if (both := _wave_both_ways(record, phases, wavelength, unsigned, freed)) is not None:
        found["wave_both_ways"] = both
    return {name: Feature(value, "1") for name, value in found.items()} | {"wave_depth": Feature(depth, "%")}


def _size(record: MotionRecord, phases: Phases, direction: int, unsigned: bool) -> float:
    """The effort that waves of a direction are a share of: its own, but at least the greater part of that of both.

    A load that drives the machine may leave hardly any effort in one direction, of which each wave would be many times.
    """
    own, other = (abs(level(record, phases, way, unsigned)) for way in (direction, -direction))
    both = float(np.sqrt(0.5 * (own**2 + other**2)))
    return own if np.isnan(other) else max(own, MOSTLY * both)


def _phasor(
    record: MotionRecord, strokes: list[tuple[Piece, np.ndarray]], size: float, wavelength: float, unsigned: bool,
    freed: bool,
) -> complex | None:  # fmt: skip
    """Phasor over the rows of all strokes, as a share of the effort ``size``; None if they do not show it."""
    where = _place(record)
    taken = []
    for piece, rows in strokes:
        effort = _along(record.effort, piece, unsigned)
        taken.append(disturbance(record, effort, rows, where, wavelength) if freed else (effort[rows], where[rows]))
    found = wave_phasor(taken, wavelength)
    return None if found is None else found / max(size, _TINY * float(np.abs(record.effort).max()))


def _wave_both_ways(
    record: MotionRecord, phases: Phases, wavelength: float, unsigned: bool, freed: bool
) -> float | None:
    """The part of the wave that is a torque of the place alone: its amplitude as a share of the effort, squared.

    None if the run does not show it. A ball that rolls into a pit helps the motion, and hinders it when it rolls out.
    On the way back, the effort against the motion therefore rises at the places where it fell. So this is the product
    of both waves with its sign reversed. Friction that depends on the place makes it negative; scatter, which the
    directions do not share, adds nothing.
    """
    where = _place(record)
    sides = []
    for direction in (1, -1):
        pieces = [(p, np.r_[(p.beginning.start + p.beginning.stop) // 2 : p.steady.stop]) for p in
                  phases.strokes(direction)]  # fmt: skip
        sides.append((_size(record, phases, direction, unsigned), pieces))
    strokes = [where[rows] for _, pieces in sides for _, rows in pieces]
    if not all(pieces for _, pieces in sides):
        return None
    low, high = max(float(stroke.min()) for stroke in strokes), min(float(stroke.max()) for stroke in strokes)
    if high - low < FEWEST_CYCLES * wavelength:
        return None
    waves = []
    for size, pieces in sides:
        common = [(p, rows[(where[rows] >= low) & (where[rows] <= high)]) for p, rows in pieces]
        waves.append(_phasor(record, common, size, wavelength, unsigned, freed))
    forward, backward = waves
    return None if forward is None or backward is None else -(forward * backward.conjugate()).real


def stroke_efforts(record: MotionRecord, unsigned: bool) -> list[tuple[np.ndarray, np.ndarray]]:
    """(effort against the motion (n,), position (n,)) of each steady stroke."""
    phases = phases_of(record)
    where = _place(record)
    strokes = phases.strokes(1) + phases.strokes(-1)
    return [(_along(record.effort, p, unsigned)[p.steady], where[p.steady]) for p in strokes]


def _scatter(record: MotionRecord, phases: Phases, wavelength: float, unsigned: bool) -> dict[str, Feature]:
    """Roughness and bumps of the steady strokes, and hunting at rest."""
    where = _place(record)
    scatters: dict[str, Callable[[np.ndarray], float]]
    scatters = {"roughness": np.std, "fast_roughness": _fast, "slow_roughness": _slow}
    sizes: dict[str, list[float]] = {name: [] for name in scatters}
    bumps = []
    error = record.position if record.command is None else record.command - record.position
    floors = _floor(record.effort), _floor(record.position)
    for pieces in filter(None, (phases.strokes(1), phases.strokes(-1))):
        left = [_residual(_along(record.effort, p, unsigned)[p.steady], where[p.steady], wavelength) for p in pieces]
        errors = [_residual(error[p.steady], where[p.steady], wavelength) for p in pieces]
        for name, of in scatters.items():
            sizes[name] += [_typical(of, rest, floor) for rest, floor in zip((left, errors), floors, strict=True)]
        bumps.append(np.mean([_bump(rest) for rest in left]))
    unit = f"({record.effort_unit} {record.position_unit})^0.5"
    found = {name: Feature(float(np.mean(np.log(its))), unit, logarithm=True) for name, its in sizes.items()}
    found["bump"] = Feature(float(np.log(np.mean(bumps) + _TINY)), "1", logarithm=True)
    if rests := phases.strokes(0):
        hunting = [
            _typical(np.std, [values[p.steady] for p in rests], floor)
            for values, floor in zip((record.effort, error), floors, strict=True)
        ]
        found["rest_hunting"] = Feature(float(np.mean(np.log(hunting))), unit, logarithm=True)
    return found


def _place(record: MotionRecord) -> np.ndarray:
    """Position over which waves are fitted: the commanded one, which has no noise, if there is one."""
    return record.position if record.command is None else record.command


def _along(effort: np.ndarray, piece: Piece, unsigned: bool) -> np.ndarray:
    """The effort against the motion of this piece."""
    return np.abs(effort) if unsigned else piece.direction * effort


def _mean(values: np.ndarray, pieces: tuple[Piece, ...]) -> float:
    return float(np.concatenate([values[piece.steady] for piece in pieces]).mean())


def _residual(values: np.ndarray, position: np.ndarray, wavelength: float) -> np.ndarray:
    if np.isfinite(wavelength):
        return beside_wave(values, position, wavelength)
    steps = np.linspace(-1.0, 1.0, len(values))
    return np.asarray(values - np.polyval(np.polyfit(steps, values, 2), steps))


def _typical(scatter: Callable[[np.ndarray], float], parts: list[np.ndarray], floor: float) -> float:
    """Geometric mean of the scatter of each part of a run: each counts once, however long and wild it is."""
    return float(np.exp(np.mean([np.log(np.hypot(scatter(part), floor)) for part in parts])))


def _floor(values: np.ndarray) -> float:
    """The least scatter of a sensor's readings (n,) that can be told from none: that of rounding to its steps."""
    return max(rounding_scatter(values), _TINY * float(np.ptp(values)))


def _fast(part: np.ndarray) -> float:
    """Root of half the mean square of the steps from sample to sample."""
    return float(np.sqrt(0.5 * np.mean(np.diff(part) ** 2)))


def _slow(part: np.ndarray) -> float:
    return float(np.convolve(part, np.full(_FEW, 1.0 / _FEW), "valid").std())


def _bump(left: np.ndarray) -> float:
    """Largest mean of a few neighbouring samples, over the scatter of all."""
    local = np.convolve(left, np.full(_LOCAL, 1.0 / _LOCAL), "valid")
    return float(np.abs(local).max() / max(float(left.std()), 1e-30))


def _peak(values: np.ndarray) -> float:
    return float(np.sort(values)[-_PEAK:].mean())


def _log(size: float, scale: float, unit: str, of_effort: bool) -> Feature:
    return Feature(float(np.log(size + _TINY * scale)), unit, logarithm=True, of_effort=of_effort)
