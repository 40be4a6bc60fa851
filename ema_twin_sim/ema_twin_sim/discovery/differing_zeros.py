"""Zeros of the motor's position that differ between recordings.

An incremental counter starts anew when it is switched on. A torque that repeats with the motor's angle then begins at
another place in each recording, and no wave explains it in all of them. But every line of the order spectrum is moved
by the same angle, which is so found.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_bench_replay.recording import Recording

from ..comparison.orders import FEWEST_CYCLES, FEWEST_SAMPLES, ORDERS
from ..criteria import CORRELATION, DEPENDS, NEGLIGIBLE, SMALL
from ..identification.fit import Fit
from ..listing import listed
from ..measured.order_spectrum import largest_in_cells, refined
from ..model import Model
from ..model.own_units import is_linear, shown
from ..plant.measured_motion import MOTOR_ANGLE
from ..quantities import quantity

LINES = 4  # most lines of the order spectrum that are used
STEP = ORDERS[1] - ORDERS[0]
FINER = 20  # angles tried within a cycle of the highest of them


@dataclass(frozen=True, eq=False)
class _Line:
    """One order, with the wave (R,) [complex, in units of noise] of each recording at it."""

    order: float
    waves: np.ndarray


@dataclass(frozen=True, eq=False)
class _Part:
    """One recording: what its fit leaves (m,), in units of noise, and the motor's angle (m,) [rad]."""

    left: np.ndarray
    angle: np.ndarray


def differing_zeros(f: Fit) -> dict[str, float]:
    """Angle [rad] to add to the motor's position, by recording; those that need none are left out.

    ``f`` is a fit without waves. Empty if the zeros agree, or if nothing tells that they do not: with an encoder on the
    output as well, and for operating points.
    """
    problem, base = f.problem, f.hypothesis.base
    if not base.other_orders or problem.rows > problem.size or len(problem.observations) < 2:
        return {}
    parts, names = [], []
    for o, rows in zip(problem.observations, problem.torque_parts, strict=True):
        if not o.of_points and len(o.rows) >= FEWEST_SAMPLES:
            left = f.residual[rows]
            parts.append(_Part(left - left.mean(), o.motor_origin + o.motion[o.rows, MOTOR_ANGLE]))
            names.append(o.name)
    if len(parts) < 2:
        return {}
    lines, noise = _lines(parts)
    if not lines:
        return {}
    weights = np.array([len(part.left) for part in parts])
    most = 2.0 * math.pi / min(line.order for line in lines)  # a cycle of the longest wave
    shifts = _shifts(lines, noise, weights, most if is_linear(base) else max(most, math.pi))
    if not _clearly_better(lines, noise, weights, shifts):
        return {}
    return {name: float(shift) for name, shift in zip(names, shifts, strict=True) if shift}


def with_zeros_moved(recordings: Sequence[Recording], by: Mapping[str, float], model: Model) -> list[Recording]:
    """The recordings (SI) with the zeros of their positions moved ``by`` angles [rad]; ``model`` is in own units."""
    per, _ = shown(model, 1.0, "rad")
    moved = []
    for recording in recordings:
        if recording.name in by:
            at = recording.motor_angle_origin
            here = per * by[recording.name] + (0.0 if math.isnan(at) else at)
            recording = replace(recording, motor_angle_origin=here)
        moved.append(recording)
    return moved


def of_differing_zeros(by: Mapping[str, float], model: Model) -> tuple[str, ...]:
    """Warning that tells ``by`` what angles [rad] the zeros were moved; none if none was. ``model`` in own units."""
    if not by:
        return ()
    each = listed(f"{quantity(*shown(model, angle, 'rad'))} for {name}" for name, angle in by.items())
    return (
        "the zero of the position differs between recordings: what repeats along it begins elsewhere. discover moved "
        f"the zeros to one; before you compare, add to the positions {each}",
    )


def _lines(parts: Sequence[_Part]) -> tuple[list[_Line], np.ndarray]:
    """The lines of the order spectrum, strongest first, and the variance (R,) of what they leave."""
    left = [part.left for part in parts]
    lines: list[_Line] = []
    for _ in range(LINES):
        of = [(values, part.angle) for values, part in zip(left, parts, strict=True)]
        power = np.sum([largest_in_cells(ORDERS, *one, FEWEST_CYCLES) for one in of], axis=0)
        strongest = int(np.argmax(power))
        near = np.abs(np.log2(ORDERS / ORDERS[strongest])) < 1.0
        background = power[near & (power > 0.0)]
        if not len(background) or power[strongest] < np.median(background) / SMALL:
            break
        order = refined(float(ORDERS[strongest]), float(STEP), of)
        waves = np.empty(len(of), complex)
        for k, (values, angle) in enumerate(of):
            columns = np.column_stack([np.cos(order * angle), np.sin(order * angle), np.ones(len(angle))])
            found = np.linalg.lstsq(columns, values, rcond=None)[0]
            waves[k] = complex(found[0], -found[1])  # of the exponential of order * angle
            left[k] = values - columns @ found
        lines.append(_Line(order, waves))
    return lines, np.array([float(values.var()) for values in left])


def _shifts(lines: Sequence[_Line], noise: np.ndarray, weights: np.ndarray, most: float) -> np.ndarray:
    """The shift (R,) [rad] of each recording at which its waves begin where those of the others do; 0 where unsure.

    Recordings are taken one after the other, the clearest first; each is compared with all before it. The smallest of
    the shifts that are nearly equally good is taken, and none where that is as good.
    """
    clear = weights * sum(np.abs(line.waves) ** 2 for line in lines) / noise
    order = np.argsort(-clear)
    highest = max(line.order for line in lines)
    half = math.ceil(FINER * most * highest / (2.0 * math.pi))
    tried = most * np.arange(-half, half + 1) / half
    tried = tried[np.argsort(np.abs(tried), kind="stable")]
    shifts = np.zeros(len(weights))
    sums, held = [weights[order[0]] * line.waves[order[0]] for line in lines], weights[order[0]]
    for k in order[1:]:
        if clear[k] < DEPENDS * CORRELATION:
            continue
        score = sum(  # how much less of its rows' squares the waves of those before leave, in units of noise
            (weights[k] / noise[k] / held) * np.real(line.waves[k] * np.conj(total) * np.exp(-1j * line.order * tried))
            for line, total in zip(lines, sums, strict=True)
        )
        least = score.max() - max(DEPENDS * CORRELATION, NEGLIGIBLE * score.max())
        best = tried[int(np.argmax(score >= least))]
        if best:  # the top of the hill whose flank that is
            hill = np.abs(tried - best) < math.pi / highest
            best = tried[hill][int(np.argmax(score[hill]))]
        shifts[k] = best
        for j, line in enumerate(lines):
            sums[j] += weights[k] * line.waves[k] * np.exp(-1j * line.order * best)
        held += weights[k]
    return shifts


def _clearly_better(lines: Sequence[_Line], noise: np.ndarray, weights: np.ndarray, shifts: np.ndarray) -> bool:
    """Whether common waves explain much more with the ``shifts`` (R,) [rad] than without, chance left aside."""

    def explained(by: np.ndarray) -> float:
        total = 0.0
        for line in lines:
            waves = line.waves * np.exp(-1j * line.order * by)
            total += 0.5 * abs(np.sum(weights / noise * waves)) ** 2 / float(np.sum(weights / noise))
        return total / CORRELATION

    before, after = explained(np.zeros(len(shifts))), explained(shifts)
    chance = DEPENDS * np.count_nonzero(shifts)
    return bool(np.any(shifts)) and bool(after - before > chance and before < (1.0 - NEGLIGIBLE) * after)
