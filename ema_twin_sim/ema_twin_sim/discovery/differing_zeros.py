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

from ema_bench_replay.recording import AT, Recording

from ..comparison.orders import FEWEST_CYCLES, FEWEST_SAMPLES, ORDERS
from ..criteria import CORRELATION, DEPENDS, MOSTLY, NEGLIGIBLE, SMALL
from ..effects import catalogue
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..identification.loads_at_an_angle import loads_of
from ..listing import listed
from ..measured.order_spectrum import largest_in_cells, refined
from ..model import Model
from ..model.own_units import is_linear, shown
from ..plant.motion import MOTOR_ANGLE
from ..quantities import quantity
from ..simulation.angle_origins import acts_at_an_angle

LINES = 4  # most lines of the order spectrum that are used
STEP = ORDERS[1] - ORDERS[0]
FINER = 20  # angles tried within a cycle of the highest of them


@dataclass(frozen=True, eq=False)
class Line:
    """One order, with the wave (R,) [complex, in units of noise] of each recording at it, and its rows (R,).

    Both are zero for a recording in which it does not repeat.
    """

    order: float
    waves: np.ndarray
    rows: np.ndarray


def differing_zeros(f: Fit) -> dict[str, float]:
    """Angle [rad] to add to the motor's position, by recording; those that need none are left out.

    Empty if the zeros agree, or if nothing tells that they do not: with an encoder on the output as well, for operating
    points, and for a model that has an effect at an angle already, which says where the zero is.
    """
    problem, base = f.problem, f.hypothesis.base
    if not base.other_orders or problem.rows > problem.size or len(problem.observations) < 2:
        return {}
    if any(map(acts_at_an_angle, base.active.values())):
        return {}
    parts = over_the_angle(problem, f.residual)
    names = list(parts)
    if len(parts) < 2:
        return {}
    lines, noise = lines_of([*parts.values()])
    if not lines:
        return {}
    shifts = _shifts(lines, noise, tried_shifts([line.order for line in lines], linear=is_linear(base)))
    if not _clearly_better(lines, noise, shifts):
        return {}
    return {name: float(shift) for name, shift in zip(names, shifts, strict=True) if shift}


def over_the_angle(problem: EquationErrorProblem, values: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """By recording: the part of ``values`` (m,) that is its own, about its mean, and the motor's angle [rad] there."""
    return {
        o.name: (values[rows] - values[rows].mean(), o.motor_origin + o.motion[o.rows, MOTOR_ANGLE])
        for o, rows in zip(problem.observations, problem.torque_parts, strict=True)
        if not o.of_points and len(o.rows) >= FEWEST_SAMPLES
    }


def as_recorded(recordings: Sequence[Recording], by: Mapping[str, float], model: Model) -> dict[str, float]:
    """The angles ``by`` [rad, motor] in the unit and at the shaft of these recordings' positions, by recording.

    ``model`` is in own units.
    """
    ratio, per = model.value("machine.gear_ratio"), shown(model, 1.0, "rad")[0]
    told = {r.name: per / ratio if f"motor_position{AT}" in r.metadata else per for r in recordings}
    return {name: told[name] * angle for name, angle in by.items()}


def with_zeros_moved(recordings: Sequence[Recording], by: Mapping[str, float]) -> list[Recording]:
    """The recordings with the zeros of their positions moved ``by`` so much, as their positions were recorded."""
    moved = []
    for recording in recordings:
        if recording.name in by:
            at = recording.motor_angle_origin
            here = by[recording.name] + (0.0 if math.isnan(at) else at)
            recording = replace(recording, motor_angle_origin=here)
        moved.append(recording)
    return moved


def of_differing_zeros(by: Mapping[str, float], model: Model, end: Model) -> tuple[str, ...]:
    """Warning that tells ``by`` how much the zeros were moved; none if none was. The ``model`` is in own units.

    ``end`` is the model that was found: with a torque that repeats with turns it tells these zeros again.
    """
    if not by:
        return ()
    _, unit = shown(model, 1.0, "rad")
    each = listed(f"{quantity(way, unit)} for {name}" for name, way in by.items())
    return (
        "the zero of the position differs between recordings: what depends on it begins elsewhere. discover moved "
        f"the zeros to one; {_then(end, each)}",
    )


def _then(end: Model, each: str) -> str:
    """What is left to do before these recordings are compared with the model that was found."""
    if waves_of(end) or loads_of(end):
        return "compare, fit and report move them to that of the new model, and say by how much"
    return f"before you compare, add to the positions {each}"


def waves_of(model: Model) -> list[str]:
    """The effects of orders. A weight over a part of a turn is no wave: its angle and its zero are told by one bend."""
    return [name for name, held in model.active.items() if catalogue()[held.effect].depends_on == "order"]


def lines_of(parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[list[Line], np.ndarray]:
    """The lines of the order spectrum, strongest first, and the variance (R,) of what they leave.

    ``parts`` are the residual (m,), in units of noise, and the motor's angle (m,) [rad] of each recording.
    """
    parts = list(parts)
    lines: list[Line] = []
    for _ in range(LINES):
        power = np.sum([largest_in_cells(ORDERS, *part, FEWEST_CYCLES) for part in parts], axis=0)
        strongest = int(np.argmax(power))
        near = np.abs(np.log2(ORDERS / ORDERS[strongest])) < 1.0
        background = power[near & (power > 0.0)]
        if not len(background) or power[strongest] < np.median(background) / SMALL:
            break
        order = refined(float(ORDERS[strongest]), float(STEP), parts)
        waves, rows = np.zeros(len(parts), complex), np.zeros(len(parts))
        for k, (values, angle) in enumerate(parts):
            if order * float(np.ptp(angle)) >= 2.0 * math.pi * FEWEST_CYCLES:
                waves[k], left = wave_at(order, values, angle)
                parts[k], rows[k] = (left, angle), len(values)
        lines.append(Line(order, waves, rows))
    return lines, np.array([float(values.var()) for values, _ in parts])


def wave_at(order: float, values: np.ndarray, angle: np.ndarray) -> tuple[complex, np.ndarray]:
    """The wave of ``values`` (m,) at an order over the ``angle`` (m,) [rad], and what it leaves of them (m,)."""
    columns = np.column_stack([np.cos(order * angle), np.sin(order * angle), np.ones(len(angle))])
    found = np.linalg.lstsq(columns, values, rcond=None)[0]
    return complex(found[0], -found[1]), values - columns @ found  # of the exponential of order * angle


def tried_shifts(orders: Sequence[float], *, linear: bool) -> np.ndarray:
    """The shifts (n,) [rad] that are tried where waves of these ``orders`` repeat, the smallest first.

    Up to a cycle of the longest wave, on a rotary machine up to half a turn: no zero is farther off.
    """
    longest = 2.0 * math.pi / min(orders)
    most = longest if linear else max(longest, math.pi)
    half = math.ceil(FINER * most * max(orders) / (2.0 * math.pi))
    tried = most * np.arange(-half, half + 1) / half
    return tried[np.argsort(np.abs(tried), kind="stable")]


def best_shift(tried: np.ndarray, score: np.ndarray, highest: float) -> float:
    """The shift [rad] of the largest ``score`` (n,) [units of noise]; of equals the smallest, and 0 if nearly equal.

    ``tried`` (n,) are the shifts, none first; ``highest`` is the order of the shortest wave.
    """
    most, chance = float(score.max()), DEPENDS * CORRELATION
    if score[0] >= most - max(chance, NEGLIGIBLE * most):
        return 0.0
    # between two cycles of the longest wave only the shorter, slighter ones decide
    best = tried[int(np.argmax(score >= most - max(chance, NEGLIGIBLE * SMALL * most)))]
    hill = np.flatnonzero(np.abs(tried - best) < math.pi / highest)  # the one whose flank that is
    hill = hill[np.argsort(tried[hill])]
    top = int(np.argmax(score[hill]))
    if not 0 < top < len(hill) - 1:
        return float(tried[hill[top]])
    before, at, after = score[hill[top - 1 : top + 2]]
    step = tried[hill[top]] - tried[hill[top - 1]]
    return float(tried[hill[top]] + 0.5 * step * (before - after) / (before - 2.0 * at + after))  # of the parabola


def _shifts(lines: Sequence[Line], noise: np.ndarray, tried: np.ndarray) -> np.ndarray:
    """The shift (R,) [rad] of each recording at which its waves begin where those of the others do; 0 where unsure.

    Recordings are taken one after the other, the clearest first; each is compared with all before it. The smallest of
    the shifts that are nearly equally good is taken, and none where that is as good.
    """
    clear = np.sum([line.rows * np.abs(line.waves) ** 2 for line in lines], axis=0) / noise
    order = np.argsort(-clear)
    highest = max(line.order for line in lines)
    shifts = np.zeros(len(noise))
    sums = [line.rows[order[0]] * line.waves[order[0]] for line in lines]
    held = [max(line.rows[order[0]], 1.0) for line in lines]
    for k in order[1:]:
        if clear[k] < DEPENDS * CORRELATION:
            continue
        # how much less of its rows' squares the mean waves of those before leave, in units of noise
        score = np.zeros(len(tried))
        for line, total, rows in zip(lines, sums, held, strict=True):
            turned = line.waves[k] * np.conj(total / rows) * np.exp(-1j * line.order * tried)
            score += line.rows[k] / noise[k] * np.real(turned)
        shifts[k] = best = best_shift(tried, score, highest)
        for j, line in enumerate(lines):
            sums[j] += line.rows[k] * line.waves[k] * np.exp(-1j * line.order * best)
            held[j] += line.rows[k]
    return shifts


def _clearly_better(lines: Sequence[Line], noise: np.ndarray, shifts: np.ndarray) -> bool:
    """Whether common waves explain much more with the ``shifts`` (R,) [rad] than without, chance left aside.

    And most of what waves of any size in each recording would: what one recording alone shows is none of the machine.
    """
    sure = [line.rows / noise for line in lines]
    alone = sum(0.5 * float(np.sum(each * np.abs(line.waves) ** 2)) for line, each in zip(lines, sure, strict=True))

    def explained(by: np.ndarray) -> float:
        total = 0.0
        for line, each in zip(lines, sure, strict=True):
            waves = line.waves * np.exp(-1j * line.order * by)
            total += 0.5 * abs(np.sum(each * waves)) ** 2 / max(float(np.sum(each)), 1.0)
        return total / CORRELATION

    before, after = explained(np.zeros(len(shifts))), explained(shifts)
    chance = DEPENDS * np.count_nonzero(shifts)
    common = after > MOSTLY * alone / CORRELATION
    return bool(np.any(shifts)) and common and bool(after - before > chance and before < (1.0 - NEGLIGIBLE) * after)
