"""Worth: the gain an effect needs to be named. Every effect and every parameter has a complexity penalty.

Penalties are in units of the noise: a chi-square corrected for the rows' correlation. An absent effect gains a few
units by chance, and more if the best of many is taken. The penalties were set on benches with nothing hidden, so that
no effect is accused there.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from ...criteria import (
    CORRELATION,
    COST_EFFECT,
    COST_OF_BASIS_COLUMN,
    COST_PARAMETER,
    DEPENDS,
    FAR_OFF_ROW,
    FEWEST_ROWS,
    LARGEST_EFFECT,
    LEAST_SIZE,
    LEAST_SIZE_BESIDE_IMPACTS,
    LEAST_SIZE_LIKE_FRICTION,
    MOSTLY,
    NEGLIGIBLE,
    PART,
    SHAKY,
    SMALL,
)
from ...effects import Trait, catalogue, effects_with, the_effect
from ...identification.comparable import refuse_different_weightings
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...identification.hypothesis import COMPLIANT_EFFECTS, Hypothesis
from ...identification.sensors import delay_of_gearbox, delay_shows
from ...measured.observation import Observation
from ...model.roles import BRISTLE, DRY_FRICTION, SENSOR_DELAY, SENSOR_WAVE
from ...plant.motion import MOTOR_ANGLE

STRAY_ROWS = 2  # of a recording, or 1 % of it: a single start or spike is no dependence
FEWEST_CYCLES = 2.0  # of a wave that is seen to repeat
BY_CONSTANTS = frozenset({"speed", "acceleration", "current"})
"""Quantities that a model's constants act on: effects over these may show only as a constant off its file."""
NOTHING_ELSE = frozenset({"acceleration", "current"})
"""For these quantities an effect shows only as constants off their file."""
NEARLY_CONSTANT = frozenset({"direction", "output_position"})
"""For these quantities an effect may be practically constant."""
ENCODER_ONLY = frozenset({SENSOR_DELAY, SENSOR_WAVE})  # effects that do not show in the torque


def complexity_penalty(f: Fit) -> float:
    """Complexity penalty of a hypothesis (added to its misfit): priors, number of effects and parameters."""
    parameters = sum(fr.path.startswith("effects.") for fr in f.hypothesis.free)
    generic_bases = sum(fr.path.startswith("basis.") for fr in f.hypothesis.free)
    return (
        f.prior_cost
        + COST_EFFECT * len(f.hypothesis.added)
        + COST_PARAMETER * parameters
        + COST_OF_BASIS_COLUMN * generic_bases
    )


def penalised_gain(before: Fit, after: Fit) -> float:
    """Gain of one fit over another, net of complexity penalties, in units of the remaining noise.

    Raises DifferentWeightings if the two do not compare, as every comparison of fits does.
    """
    fall = np.subtract(before.misfits, after.misfits)
    gained = float(np.sum(fall / noise_per_unit(before, after)))
    return gained + complexity_penalty(before) - complexity_penalty(after)


def noise_per_unit(before: Fit, after: Fit) -> np.ndarray:
    """Difference of misfits that counts as one, for torque rows and encoder rows (2,).

    It is larger with an output that bounces, because more is fitted by chance there.
    """
    refuse_different_weightings(before, after)
    shaky = SHAKY if before.parted and after.parted else 1.0
    return shaky * np.minimum(before.variance_inflations, after.variance_inflations)


def largest_rms_reduction(problem: EquationErrorProblem, before: Fit, after: Fit) -> float:
    """Largest rms, in units of noise, that an effect removes from any one recording's rows.

    With backlash or compliance, a torque effect must show in the torque and not right after an impact: no contact law
    is accurate there, nor where the output comes to rest.
    """
    refuse_different_weightings(before, after)
    came = set(after.hypothesis.effects) - set(before.hypothesis.effects)
    by_torque = before.parted and after.parted and not came & ENCODER_ONLY
    fell = after.weights**2 * (before.raw**2 - after.raw**2)
    best = 0.0
    for k, part in enumerate(problem.torque_parts):
        rows = fell[part][problem.observations[k].below_shock_limit] if by_torque else fell[part]
        if _informative(problem.observations[k], len(rows)):
            best = max(best, float(np.mean(rows)))
    for part in () if by_torque else problem.encoder_parts:
        if part.stop - part.start >= FEWEST_ROWS:
            best = max(best, float(np.mean(fell[part])))
    return math.sqrt(best)


def _informative(o: Observation, count: int) -> bool:
    """Whether so many rows tell a mean square. Operating points have no neighbours like themselves: each counts."""
    return count * (CORRELATION if o.of_points else 1.0) >= FEWEST_ROWS


def is_lacked(h: Hypothesis, effect: str) -> bool:
    """Whether an added effect is one that every machine has and that the base model lacks."""
    return catalogue()[effect].every_machine and h.count(effect) == 1


def standing_on(h: Hypothesis, name: str) -> tuple[str, ...]:
    """The added friction that is in excess of an added dry friction, if that is the only one; else nothing.

    A level that fades over all recorded speeds does what dry friction does, which every machine has: it never stays
    without it.
    """
    if name not in h.added or h.added[name].effect != DRY_FRICTION or h.count(DRY_FRICTION) > 1:
        return ()
    above = effects_with(Trait.ABOVE_DRY_FRICTION)
    return tuple(other for other, instance in h.added.items() if instance.effect in above)


def has_effect_size(problem: EquationErrorProblem, before: Fit, after: Fit) -> bool:
    """Whether a step is large enough to be named."""
    refuse_different_weightings(before, after)
    came = {n: held.effect for n, held in after.hypothesis.added.items() if n not in before.hypothesis.added}
    if any(
        does_nothing(after, name)
        or _never_slides(problem, after, name)
        or _too_large(problem, after, name)
        or _within_counts(after, name)
        or _within_steps(problem, after, name)
        or _hardly_repeats(problem, before, after, name)
        for name in came
    ):
        return False
    over = {catalogue()[id].depends_on for id in came.values()}
    if over == {"encoders"} and _hardly_parts(problem, before, after):
        return False
    if over <= NOTHING_ELSE and not after.parted and penalised_gain(before, after) > 0.0:
        # Constants could do the same: the rows gain what their priors kept the constants from doing. With impacts it
        # may be what no contact law gets right.
        return True
    relief = before.prior_cost - after.prior_cost
    if relief > COST_EFFECT + COST_PARAMETER and over <= BY_CONSTANTS:
        return True
    if before.parted != after.parted or "encoders" in over:
        count, misfit, remains = problem.judged, before.misfit, after.misfit
    else:  # encoder residuals do not affect torque effects
        count = problem.size
        misfit, remains = before.misfits[0], after.misfits[0]
    fall, excess = misfit - remains, max(misfit - count, 0.0)
    left = math.sqrt(max(1.0, remains / count))
    floor = LEAST_SIZE_BESIDE_IMPACTS if after.parted else LEAST_SIZE
    if [*came.values()] == [the_effect(Trait.FRICTION_UNDER_LOAD)]:
        if all(catalogue()[id].depends_on != "output_position" for id in after.hypothesis.held):  # no load varies
            floor = max(floor, LEAST_SIZE_LIKE_FRICTION)
        elif after.parted and penalised_gain(before, after) > DEPENDS:
            # a few per cent of a load are smaller than other effects, but nothing else follows the load's size
            floor *= 0.5
    if over == {"order"} and (not after.parted or penalised_gain(before, after) > DEPENDS):
        # no typical model error looks like a wave over the angle, except an impact now and then
        floor *= 0.5
    # Interpolation error of an encoder may separate the encoders far more than a delay does.
    late = problem.size > 0 and bool(came) and not after.parted and all(catalogue()[id].delays for id in came.values())
    if late and delay_of_gearbox(problem, before):
        return False
    considerable = fall >= SMALL * excess or (late and delay_shows(problem, before))
    return considerable and largest_rms_reduction(problem, before, after) >= floor * left


def does_nothing(f: Fit, name: str) -> bool:
    """Whether an effect's stiffness is at its upper limit, where it has no action: it stands in for another effect."""
    size = catalogue()[f.hypothesis.added[name].effect].parameters[0]
    path = f"effects.{name}.stiffness"
    if size.name != "stiffness" or size.neutral is not None:
        return False
    upper = next(free.upper for free in f.hypothesis.free if free.path == path)
    return f.hypothesis.by_path[path] >= (1.0 - NEGLIGIBLE) * upper


def left_over(problem: EquationErrorProblem, f: Fit) -> list[float]:
    """Torque [N m] that each recording leaves unexplained beyond its noise, outside impacts."""
    parted = f.parted
    found = []
    for o, part in zip(problem.observations, problem.torque_parts, strict=True):
        z = f.raw[part][
            o.below_shock_limit & ~o.after_impact[o.rows] if parted else o.below_shock_limit
        ]  # standstill rows were left out before
        if not _informative(o, len(z)):
            found.append(0.0)
            continue
        sizes = np.sort(np.minimum(np.abs(z), FAR_OFF_ROW))[: -max(STRAY_ROWS, len(z) // 100)]
        excess = max(float(np.mean(sizes**2)) - 1.0, 0.0)
        found.append(math.sqrt(excess) * float(np.median(o.torque_noise)))
    return found


def _hardly_parts(problem: EquationErrorProblem, before: Fit, after: Fit) -> bool:
    """Whether almost none of the encoder difference was removed. With open constants nothing stricter can be tested.

    An encoder error that is small in the whole counts if it is most of what errors of another kind leave: a delay
    shifts the readings in time and an angle error by angle, each exactly, so neither leaves the shape of the other.
    """
    if not after.hypothesis.base.is_open:
        return False
    came = {i.effect for n, i in after.hypothesis.added.items() if n not in before.hypothesis.added}
    # An encoder's error may be far larger than the backlash, so backlash is judged by what that error leaves.
    known_errors = not problem.size or not ENCODER_ONLY.isdisjoint(before.hypothesis.effects)
    beside_errors = known_errors and not came.isdisjoint(COMPLIANT_EFFECTS)
    gone = sum(
        float(np.sum((before.raw[part] ** 2 - after.raw[part] ** 2) * problem.noise_of_encoders(part) ** 2))
        for part in problem.encoder_parts
    )
    if gone >= NEGLIGIBLE * _parted(problem, before.raw if beside_errors else problem.measured):
        return False
    return gone < MOSTLY * _parted(problem, problem.measured - _shown_by_other_errors(problem, before, came))


def _parted(problem: EquationErrorProblem, rows: np.ndarray) -> float:
    """Power [rad^2] of the encoder difference in ``rows`` (m,), each recording having its own offset."""
    parts = [rows[part] * problem.noise_of_encoders(part) for part in problem.encoder_parts]
    return sum(float(np.sum((part - np.mean(part)) ** 2)) for part in parts if len(part))


def _shown_by_other_errors(problem: EquationErrorProblem, f: Fit, came: Collection[str]) -> np.ndarray:
    """Rows (m,) that a fit's encoder errors of other kinds than those that ``came`` predict, if only these came."""
    h, others = f.hypothesis, ENCODER_ONLY - {*came}
    if not ENCODER_ONLY.issuperset(came) or others.isdisjoint(h.held):
        return np.zeros(problem.rows)
    base = replace(h.base, effects={n: i for n, i in h.base.effects.items() if i.effect not in others})
    less = replace(h, base=base).without(*(n for n, i in h.added.items() if i.effect in others))
    return f.predicted.rows - problem.predict(less).rows


def _too_large(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an effect's torque exceeds everything measured: smoothing removes nearly all of a fast wave."""
    instance = f.hypothesis.instance(name)
    size = catalogue()[instance.effect].parameters[0]
    most = LARGEST_EFFECT * float(np.abs(problem.torque).max(initial=0.0))
    return size.unit == "N m" and abs(instance.parameters[size.name]) > most


def _within_counts(f: Fit, name: str) -> bool:
    """Whether an angle error is below one count of the coarser encoder: rounding looks the same."""
    instance = f.hypothesis.instance(name)
    size = catalogue()[instance.effect].parameters[0]
    if catalogue()[instance.effect].depends_on != "encoders" or size.name != "amplitude":
        return False
    value = f.hypothesis.base.value
    counts = min(
        value("sensors.output_encoder_counts"), value("sensors.motor_encoder_counts") * value("machine.gear_ratio")
    )
    return abs(instance.parameters[size.name]) < f.hypothesis.base.turn / counts


def _within_steps(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether a load, or a torque that differs by direction, is below one step of the torque reading.

    A drive that rounds down looks like such a load. The effect is measured where it acts: a magnet that pulls within a
    few millimetres does nothing in most rows of a longer way, and no rounding has its size. Tested only with open
    constants; otherwise the model file says how the sensor reads.
    """
    instance = f.hypothesis.instance(name)
    if catalogue()[instance.effect].depends_on not in NEARLY_CONSTANT or not f.hypothesis.base.is_open:
        return False
    step = max((o.torque_step for o in problem.observations if len(o.rows)), default=0.0)
    if not step:
        return False
    size = catalogue()[instance.effect].parameters[0]
    slope = f.slopes()[f"effects.{name}.{size.name}"][: problem.size]
    return abs(instance.parameters[size.name]) * size_where_it_acts(slope * problem.noise) < step


def size_where_it_acts(action: np.ndarray) -> float:
    """Median of the sizes of an effect's action over rows (n,), without those in which it does next to nothing."""
    sizes = np.abs(action)
    acts = sizes >= SMALL * float(sizes.max(initial=0.0))
    return float(np.median(sizes[acts])) if acts.any() else 0.0


def _hardly_repeats(problem: EquationErrorProblem, before: Fit, after: Fit, name: str) -> bool:
    """Whether a wave explains mostly recordings in which it does not come a second time, on a machine of other orders.

    There it is a bend of the torque over the angle, and where it repeats it should explain as much.
    """
    h = after.hypothesis
    instance = h.added[name]
    of_encoders = catalogue()[instance.effect].depends_on == "encoders"
    if not h.base.other_orders or of_encoders or "order" not in instance.options:
        return False
    order = h.model().motor_order(name)
    fell = after.weights**2 * (before.raw**2 - after.raw**2)
    there = {True: 0.0, False: 0.0}
    for o, part in zip(problem.observations, problem.torque_parts, strict=True):
        turns = float(np.ptp(o.motion[:, MOTOR_ANGLE])) / (2.0 * math.pi)
        there[turns * order >= FEWEST_CYCLES] += float(fell[part].sum())
    return there[True] < PART * max(sum(there.values()), 0.0)


def _never_slides(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether a bristle gives way over a considerable part of the travel: it is a spring then, or some other load."""
    instance = f.hypothesis.instance(name)
    if instance.effect != BRISTLE:
        return False
    active = f.hypothesis.model().active.values()
    dry = sum(held.parameters["torque"] for held in active if held.effect == DRY_FRICTION)
    travel = max((float(np.ptp(o.motion[:, MOTOR_ANGLE])) for o in problem.observations), default=0.0)
    return dry > PART * travel * instance.parameters["stiffness"]
