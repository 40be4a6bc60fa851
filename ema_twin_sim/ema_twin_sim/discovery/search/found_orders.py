"""Orders found in a residual, for a machine whose orders are not all known."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence

import numpy as np

from ...comparison.orders import Periodicity, find_order
from ...criteria import CONTRADICTED, CORRELATION, NEARLY_ALL, NEGLIGIBLE, SMALL
from ...effects import Trait, catalogue, the_effect
from ...identification.candidates import Candidate, addable
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit
from ...measured.observation import Observation
from ...model import Model
from ...model.own_units import is_linear
from ...model.roles import SENSOR_WAVE
from ...plant.layout import OUTPUT_TORQUE
from ...plant.motion import MOTOR_ANGLE, OUTPUT_ANGLE, SPEED
from ..criteria.worth import FEWEST_CYCLES

HIGHEST = 160
HIGHEST_UNGEARED = 400  # a torque motor of 22 pole pairs and 24 slots cogs 264 times a turn
HIGHEST_OF_MOTOR = 24  # of the motor's encoder
MOST = 3  # orders that are tried in a round
FEWEST_TURNS = 0.4  # of the motor, for orders of few cycles in them
MANY_CYCLES = 8.0  # of a wave that less of a turn shows
SLOW = 0.1  # quantile of the speeds: slow motion resolves a wave that fast motion skips
LEAST_DIGITS, MOST_DIGITS = 3, 15  # digits that an order is written with
SAME = 1e-4  # rad, within which two points count as one angle


def order_candidates(
    problem: EquationErrorProblem, f: Fit, without: Collection[str] = frozenset()
) -> Iterator[Candidate]:
    """Effects with a free order, at the orders that stand out in a fit's residual; none of those in ``without``.

    None if the machine has only the usual orders.

    What the motor's own turns cause repeats with each turn: its orders are whole numbers, including those of the
    electrical angle. What turns with the output has whole orders there. Gears and bearings have orders of their own.
    """
    base = f.hypothesis.base
    if not base.other_orders:
        return
    ratio = base.value("machine.gear_ratio")
    if is_linear(base):  # magnets or a screw repeat along its way, at any order of the drum that stands for it
        strongest = _strongest(problem, f)
        wave = the_effect(Trait.MOTOR_WAVE)
        if strongest is not None and wave not in without and not _beside_another(problem, f, strongest.order):
            yield Candidate(wave, {"order": _as_known(problem, strongest)})
        return
    found: list[tuple[str, Callable[[], Sequence[str]]]] = [
        (the_effect(Trait.MOTOR_WAVE), lambda: standing_out(problem, f)),
        (SENSOR_WAVE, lambda: of_the_encoders(problem, f, ratio)),
        (the_effect(Trait.MOTOR_WAVE if ratio == 1.0 else Trait.GEAR_WAVE), lambda: of_the_gears(problem, f)),
    ]
    if ratio != 1.0:  # otherwise the output's angle is the motor's
        found.insert(1, (the_effect(Trait.OUTPUT_WAVE), lambda: standing_out(problem, f, ratio)))
    held = {(i.effect, i.options.get("order")) for i in f.hypothesis.added.values()}
    for id, orders in found:
        effect = catalogue()[id]
        if id in without or not addable(f.hypothesis, id):
            continue
        for order in orders():
            known = (id, order) in held or (effect.searched and order in effect.options["order"])
            torque = effect.depends_on != "encoders"
            if not known and not (torque and _beside_another(problem, f, motor_order(id, float(order), ratio))):
                yield Candidate(id, {**effect.default_options(), "order": order})


def _beside_another(problem: EquationErrorProblem, f: Fit, order: float) -> bool:
    """Whether an ``order`` of the motor is hardly another one than that of a torque that the model already has.

    Two waves are told apart where one makes more cycles than the other: one more if both are whole, as the motor's own
    are. Any other order must make two more. With fewer it is how the first one swells and fades, where a slow sampling
    or a filter takes a part of it at high speed; over part of a turn, neighbouring whole orders are a curve's shape.
    """
    model = f.hypothesis.model()
    apart = (1.0 if _is_whole(order) else FEWEST_CYCLES) / max(_turns(problem), NEGLIGIBLE)
    waves = [
        n for n, i in model.active.items() if "order" in i.options and catalogue()[i.effect].depends_on != "encoders"
    ]
    return any(0.0 < abs(order - model.motor_order(name)) < apart for name in waves)


def motor_order(effect: str, order: float, gear_ratio: float) -> float:
    """An effect's order in cycles per motor turn."""
    found = catalogue()[effect]
    return order / gear_ratio if found.where(found.default_options()) == OUTPUT_TORQUE else order


def of_the_gears(problem: EquationErrorProblem, f: Fit) -> list[str]:
    """The strongest of all resolved orders; none if it is unclear, or not clearly other than whole (of a shaft)."""
    strongest = _strongest(problem, f)
    if strongest is None or _is_whole(strongest.order):
        return []
    away = abs(strongest.order - round(strongest.order))
    return [] if away < CONTRADICTED * _order_error(problem, strongest) else [_as_known(problem, strongest)]


def _strongest(problem: EquationErrorProblem, f: Fit) -> Periodicity | None:
    """The strongest of all resolved orders of the motor; None if it is unclear."""
    parts = []
    for o, part in zip(problem.observations, problem.torque_parts, strict=True):
        angle, speed = o.motor_origin + o.motion[o.rows, MOTOR_ANGLE], o.motion[o.rows, SPEED]
        if not o.of_points:
            parts.append((f.residual[part], angle, np.sign(speed)))
    strongest = find_order(parts)
    if strongest is None or strongest.dissipative or strongest.share < (1.0 - NEARLY_ALL):
        return None
    return strongest


def _order_error(problem: EquationErrorProblem, found: Periodicity) -> float:
    """Standard error of a resolved order; no less than a small share of the cycle that its turns can tell apart.

    Over less than a turn, whatever else the residual holds moves the order by more than noise does.
    """
    return max(math.sqrt(CORRELATION) * found.order_std, SMALL / max(_turns(problem), NEGLIGIBLE))


def _as_known(problem: EquationErrorProblem, found: Periodicity) -> str:
    """A resolved order as its standard error lets it be written."""
    return written_order(found.order, _order_error(problem, found))


def written_order(order: float, std: float) -> str:
    """An order, rounded to a tenth of its standard error, as the model file keeps it and as it is fitted.

    Over many turns an error in the fifth digit would shift a wave out of phase.
    """
    digits = MOST_DIGITS
    if std > 0.0:
        digits = min(max(1 + math.ceil(math.log10(order / std)), LEAST_DIGITS), digits)
    return f"{order:.{digits}g}"


def of_the_encoders(problem: EquationErrorProblem, f: Fit, gear_ratio: float) -> list[str]:
    """Orders, in cycles per output turn, at which the encoders differ most: whole orders of either shaft."""
    powers: dict[float, float] = {}
    for o, part in zip(problem.observations, problem.encoder_parts, strict=True):
        angle = o.output_origin + o.motion[o.encoder_rows, OUTPUT_ANGLE]
        if not len(angle):
            continue
        turns = float(np.ptp(angle)) / (2.0 * np.pi)
        speed = float(np.quantile(np.abs(o.motion[o.encoder_rows, SPEED]), SLOW)) / gear_ratio
        highest = 2.0 * np.pi / (speed * o.period * len(o.kernel)) if speed > 0.0 else math.inf
        residual = f.residual[part] - f.residual[part].mean()
        each: dict[float, float] = {}
        for per_turn, most in ((1.0, HIGHEST), (gear_ratio, HIGHEST_OF_MOTOR)):
            for order, power in enumerate(_powers(residual, per_turn * angle, most), 1):
                if per_turn * order * turns > FEWEST_TURNS and per_turn * order < highest:
                    each.setdefault(round(per_turn * order, 6), power)
        for at, power in each.items():
            powers[at] = powers.get(at, 0.0) + power
    strongest = sorted(powers, key=lambda order: (-powers[order], order))
    return [f"{order:.10g}" for order in strongest[:MOST] if powers[order] > 0.0]


def _powers(residual: np.ndarray, angle: np.ndarray, most: int) -> Iterator[float]:
    """Power of a residual (n,) in waves of 1, 2, ... ``most`` cycles a turn of an angle (n,) [rad]."""
    turn = np.exp(1j * angle)
    wave = np.ones(len(angle), complex)
    for _ in range(most):
        wave *= turn
        yield float(abs(residual @ wave)) ** 2 / len(angle)


def highest_order(o: Observation) -> float:
    """The order from which on an observation does not resolve a wave: two samples per cycle, no aliases.

    Operating points must lie as close as that over half of what they cover: readings that scatter about a few places
    are close to each other, and tell nothing of what is between the places.
    """
    if not o.of_points:
        step = float(np.quantile(np.abs(o.motion[o.rows, SPEED]), SLOW)) * o.period if len(o.rows) else 0.0
        return np.pi / step if step > 0.0 else np.inf
    angle = o.motion[o.rows, MOTOR_ANGLE]
    if len(angle) < 2 or np.ptp(angle) == 0.0:
        return 0.0
    turned = np.mod(angle, 2.0 * np.pi) if np.ptp(angle) > 2.0 * np.pi else angle
    steps = np.sort(np.diff(np.unique(np.round(turned / SAME)))) * SAME
    if not len(steps):
        return 0.0
    covered = np.cumsum(steps)
    return float(np.pi / steps[np.searchsorted(covered, 0.5 * covered[-1])])


def resolved(problem: EquationErrorProblem, options: Iterable[Candidate], model: Model) -> list[Candidate]:
    """The candidates that the recordings can resolve.

    Left out are: effects that repeat with each turn, if the motor made too little of one and not many of their cycles;
    orders that operating points do not resolve; and, on a machine with unknown orders, waves of which less than two
    cycles were recorded. Over part of a turn, as in a torsion test, waves of several orders imitate any shape.
    """
    turns = _turns(problem)
    of_points = all(o.of_points for o in problem.observations)
    highest = max((highest_order(o) for o in problem.observations), default=np.inf) if of_points else np.inf

    def shows(c: Candidate) -> bool:
        effect = catalogue()[c.effect]
        repeats = effect.depends_on == "order" or (
            effect.depends_on != "encoders" and any(p.periodic for p in effect.parameters)
        )
        by_turns = repeats and effect.depends_on != "output_position"
        order = motor_order(c.effect, float(c.options.get("order", 1.0)), model.value("machine.gear_ratio"))
        # Gravity, which has no free order, is known to exist; a slow bend of torque over angle looks like a wave.
        unseen = model.other_orders and turns * order < FEWEST_CYCLES and (by_turns or "order" in c.options)
        if (by_turns and turns < FEWEST_TURNS and turns * order < MANY_CYCLES) or (repeats and unseen):
            return False
        return "order" not in c.options or order < highest

    return [c for c in options if shows(c)]


def is_bend(problem: EquationErrorProblem, f: Fit, name: str) -> bool:
    """Whether an added effect is a wave of which few cycles were recorded, within less than a turn of its shaft.

    There it is a curve over the angle, like any other. Only a whole turn shows that it repeats, and many cycles do.
    """
    instance = f.hypothesis.added[name]
    effect = catalogue()[instance.effect]
    if effect.depends_on == "encoders":
        return False
    if "order" not in instance.options:  # once per turn of the motor, or many times where the current makes it
        return effect.depends_on == "order" and Trait.BY_CURRENT not in effect.traits and _turns(problem) < 1.0
    cycles = _turns(problem) * f.hypothesis.model().motor_order(name)
    return cycles < (1.0 - NEGLIGIBLE) * min(float(instance.options["order"]), MANY_CYCLES)


def standing_out(problem: EquationErrorProblem, f: Fit, gear_ratio: float | None = None) -> list[str]:
    """The orders with the most power, in cycles per motor turn, up to what the samples resolve.

    Over part of a turn, neighbouring orders are the same wave, and only the strongest of them counts. With a
    ``gear_ratio``: in cycles per output turn, without those that are also whole for the motor. Without order 1 of the
    output, which is gravity.
    """
    at_output = gear_ratio is not None
    per_turn = gear_ratio or 1.0
    direct = not at_output and f.hypothesis.base.value("machine.gear_ratio") == 1.0
    most = HIGHEST_UNGEARED if direct else HIGHEST
    power = np.zeros(most + 1)
    for o, part in zip(problem.observations, problem.torque_parts, strict=True):
        angle = o.motor_origin + o.motion[o.rows, MOTOR_ANGLE]
        if at_output:
            angle = o.output_origin + o.motion[o.rows, OUTPUT_ANGLE]
        if not len(angle):
            continue
        turns = float(np.ptp(angle)) / (2.0 * np.pi)
        lowest = 0.0 if turns >= FEWEST_TURNS else MANY_CYCLES / turns if turns > 0.0 else math.inf
        highest = highest_order(o) * per_turn
        residual = f.residual[part] - f.residual[part].mean()
        for order, found in enumerate(_powers(residual, angle, most), 1):
            gravity = order == 1 and (at_output or direct)
            if lowest < order < highest and not gravity and not (at_output and _is_whole(order / per_turn)):
                power[order] += found
    apart = 1.0 / min(max(_turns(problem) / per_turn, 1.0 / most), 1.0)
    taken: list[int] = []
    for order in np.argsort(-power):
        if len(taken) == MOST or power[order] == 0.0:
            break
        if all(abs(order - other) >= apart for other in taken):
            taken.append(int(order))
    return [str(order) for order in taken]


def _turns(problem: EquationErrorProblem) -> float:
    """The most motor turns of any recording."""
    return max((float(np.ptp(o.motion[:, MOTOR_ANGLE])) for o in problem.observations), default=0.0) / (2.0 * np.pi)


def _is_whole(order: float) -> bool:
    return round(order) > 0 and abs(order - round(order)) < NEGLIGIBLE
