"""The search for the effects that a model lacks."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...criteria import (
    BESIDE_IMPACTS,
    CLEARLY_MORE,
    CORRELATION,
    COST_OF_BASIS_COLUMN,
    MISFIT_DOUBTED,
    MISFIT_LEFT,
    MOST_EFFECTS,
    USUAL_EFFECTS,
)
from ...effects import Trait, effects_with
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.generic_bases import beside_generic_bases, dependence
from ...identification.hypothesis import COMPLIANT_EFFECTS, Hypothesis
from ...identification.screening import screen_generic_bases
from ...identification.wander import Wander
from ...identification.wandering import wandering
from ...identification.weighting import FAR
from ...model.roles import FRICTION
from ..criteria.worth import (
    ENCODER_ONLY,
    complexity_penalty,
)
from .adding import add_effects, add_structure, added_and_removed, beside_impacts, settle
from .removing import significant
from .trace import Round, Search


def parted_encoders(f: Fit) -> bool:
    """Whether the encoders part by more than their noise."""
    return any(
        p.stop > p.start and float(np.sqrt(np.mean(f.raw[p] ** 2))) > CLEARLY_MORE for p in f.problem.encoder_parts
    )


@dataclass(frozen=True)
class _Asked:
    """What a search is asked: where it begins, what its rounds may not add, and how many there may be.

    ``by_torque`` are the effects that stay out while the torque alone is looked at, ``without`` those that always do.
    """

    null: Hypothesis
    without: frozenset[str]
    by_torque: frozenset[str]
    progress: Callable[[str], None]
    most: int


def search(
    problem: EquationErrorProblem,
    null: Hypothesis,
    without: frozenset[str] = frozenset(),
    progress: Callable[[str], None] = lambda text: None,
    most: int = MOST_EFFECTS,
    may_wander: bool = True,
) -> Search:
    """Add effects to ``null``, each worth its price, and drop what later ones make needless.

    In each of its phases a search goes ``most`` rounds; where constants are known, it ends with seven effects in all.
    Where the encoders part, what the torque alone tells is found first, then play and spring, then all together: a
    gearbox can only be simulated with the right loads. Where what is left of the torque is friction that wanders, and
    ``may_wander``, the search begins anew with that as part of the noise.
    """
    bare = settle(fit(problem.under(problem.weighting.begun_anew(FAR)), null))
    if null.base.value("machine.output_inertia") == 0.0:
        without = without | set(COMPLIANT_EFFECTS)  # there is nothing behind the teeth
    if not problem.size:
        return _by_encoders_alone(bare, without, progress, most)
    parts = parted_encoders(bare) and not without >= {*COMPLIANT_EFFECTS, *ENCODER_ONLY}
    # without the encoders calling for it, what they alone show has no place
    by_torque = without | (_misleading(null) if parts else ENCODER_ONLY)
    if parts:
        progress("looking at the torque alone")
    begun = fit(bare.problem.by_torque_alone(), bare.hypothesis) if parts else bare
    may_wander = may_wander and begun.problem.weighting.wander is None and not null.base.is_open
    asked = _Asked(null, without, by_torque, progress, most)
    current, rounds = _add_effects_or_wander(asked, begun, [], may_wander)
    if parts:
        current, rounds = _beside_encoders(asked, current, rounds, may_wander)
    return significant(Search(current, tuple(rounds)))


def _misleading(null: Hypothesis) -> frozenset[str]:
    """Effects that the torque alone must not be asked for while the gearbox is in doubt."""
    return ENCODER_ONLY | effects_with(Trait.LIKE_PLAY_OR_SPRING) | (null.held & {*FRICTION})


def _beside_encoders(asked: _Asked, current: Fit, rounds: list[Round], may_wander: bool) -> tuple[Fit, list[Round]]:
    """What the torque alone told, then play and spring, then all together.

    Where a rigid train would take suspiciously many effects and wandering explains the torque instead, the encoders are
    asked beside that.
    """
    # of what the torque alone took so many effects for, it was asked already
    may_wander = may_wander and current.problem.weighting.wander is None and not _many(current)
    current = fit(beside_impacts(current.problem.with_encoders()), current.hypothesis)
    if parted_encoders(current):
        asked.progress("looking at the gearbox")
        current, by_gearbox = add_structure(current, asked.without)
        rounds = [*rounds, *by_gearbox]
    if current.parted:
        return _beside_gearbox(asked, current, rounds, may_wander)
    current, rounds = _add_effects_or_wander(asked, current, rounds, may_wander)
    if may_wander and current.problem.weighting.wander is not None:
        return _beside_encoders(asked, current, rounds, False)
    return current, rounds


def _beside_gearbox(asked: _Asked, current: Fit, rounds: list[Round], may_wander: bool) -> tuple[Fit, list[Round]]:
    """More effects beside play or a spring, until none is worth its price.

    Where friction that wanders gains more than the first of them, they are looked for beside that, if it leaves nothing
    of the torque: one after another, friction curves would take its place.
    """
    after, first = add_effects(current, asked.without, asked.progress, most=1)
    if may_wander and first and first[0].added and (wander := _rather_wander(first[0])) is not None:
        asked.progress(f"friction seems to wander by {wander.share:.1%}: looking for more beside that")
        plain = current.problem
        problem = plain.under(replace(plain.weighting.begun_anew(BESIDE_IMPACTS), wander=wander))
        begun = settle(fit(problem, current.hypothesis))
        beside, more = add_effects(begun, asked.without, asked.progress, most=asked.most)
        if _explains_the_torque(plain, beside, wander):
            return beside, [*rounds, *more]
    if not first or not first[0].added:
        return current, [*rounds, *first]
    excluded = asked.without | added_and_removed(first)
    after, more = add_effects(after, excluded, asked.progress, most=asked.most - 1)
    return after, [*rounds, *first, *more]


def _explains_the_torque(plain: EquationErrorProblem, beside: Fit, wander: Wander) -> bool:
    """Whether friction that wanders leaves nothing of the torque, and no dependence on anything else does as well."""
    left = torque_left(beside)
    paid = left + CORRELATION * wander.complexity_penalty / plain.size
    return left <= MISFIT_LEFT and not depends_on_more(plain, beside.hypothesis, paid)


def _by_encoders_alone(bare: Fit, without: frozenset[str], progress: Callable[[str], None], most: int) -> Search:
    """The search where no torque was measured: what lets the encoders part, and what is amiss with them."""
    current = bare
    rounds: list[Round] = []
    # an encoder's error may be larger than the play beside it, which shows once that error is found
    while len(rounds) < most and parted_encoders(current) and not _gives_way(current):
        progress("looking at the gearbox")
        current, turns = add_structure(current, without)
        rounds += turns
        if not turns[-1].added:
            break
    current, further = add_effects(current, without, progress, most=most)
    return significant(Search(current, (*rounds, *further)))


def _gives_way(f: Fit) -> bool:
    """Whether play or a spring was found."""
    return not {*f.hypothesis.effects}.isdisjoint(COMPLIANT_EFFECTS)


def _add_effects_or_wander(asked: _Asked, begun: Fit, rounds: list[Round], may_wander: bool) -> tuple[Fit, list[Round]]:
    """More effects after ``rounds``, until none is worth its price; or anew, by the torque, beside wandering friction.

    Wandering is asked for in each round, until it is refused once: where it gains more by the torque than the effect
    that the round took, the search begins anew beside it. (Where much is left, an effect's gain counts more than the
    same fall of the misfit does for wandering: effects come first.) It is asked for again where something is left in
    the end, or as soon as suspiciously many effects leave nothing. More of them only make what they explain cheaper:
    what is refused beside that many is refused beside more.
    """
    later = bool(rounds)  # what the torque alone leaves was asked before
    without = asked.without if later else asked.by_torque
    if not may_wander:
        current, more = add_effects(begun, without, asked.progress, most=asked.most)
        return current, [*rounds, *more]
    current, more = begun, []
    weaker, refused = later, False  # whether wandering explains less than effects do, and than many of them do
    while len(more) < asked.most:
        after, turns = add_effects(current, without | added_and_removed(more), asked.progress, most=1)
        if not turns or not turns[0].added:
            more += turns
            break
        if not weaker and (wander := _rather_wander(turns[0])) is not None:
            beside = _beside_wander(asked, begun.problem, current, [*rounds, *more], wander)
            if beside is not None:
                return beside
            weaker = True
        current, more = after, [*more, *turns]
        if _many(current) and not refused:
            beside = _beside_wander(asked, _by_torque(current, later), current, [*rounds, *more])
            if beside is not None:
                return beside
            refused = True
    rounds = [*rounds, *more]
    many = _many(current)
    if (refused and many) or not (many or (torque_left(current) > MISFIT_LEFT and not later)):
        return current, rounds
    return _beside_wander(asked, _by_torque(current, later), current, rounds) or (current, rounds)


def _rather_wander(turn: Round) -> Wander | None:
    """How friction wanders, where that gains more by the torque than the effect that a round took; None where less."""
    wander = wandering(turn.before.problem, turn.before)
    took = next(trial for trial in turn.tried if trial.names == turn.added)
    return wander if wander is not None and wander.gain > took.gain else None


def _by_torque(f: Fit, later: bool) -> EquationErrorProblem:
    """The problem that is asked for wandering: of the torque alone where the encoders' part came ``later``."""
    return f.problem.by_torque_alone() if later else f.problem


def _many(f: Fit) -> bool:
    """Whether more effects that a torque shows were added than a machine may usually lack."""
    return sum(i.effect not in ENCODER_ONLY for i in f.hypothesis.added.values()) > USUAL_EFFECTS


def _beside_wander(
    asked: _Asked, plain: EquationErrorProblem, current: Fit, rounds: list[Round], wander: Wander | None = None
) -> tuple[Fit, list[Round]] | None:
    """The end and the rounds begun anew beside friction that wanders; None where that does not explain the torque.

    How it wanders is told by the end, or before many effects hid it, where it is not known yet (``wander``).
    """
    if wander is None:
        taken = [turn.after for turn in rounds if turn.added]
        wander = wandering(plain, taken[1] if _many(current) and len(taken) > 1 else current)
    if wander is None:
        return None
    cost_of_many = _torque_cost(current) if _many(current) else math.inf
    asked.progress(f"friction seems to wander by {wander.share:.1%}: beginning anew beside that")
    anew = plain.under(replace(plain.weighting.begun_anew(FAR), wander=wander))
    beside, rounds_beside = add_effects(settle(fit(anew, asked.null)), asked.by_torque, asked.progress, most=asked.most)
    too_dear = _torque_cost(beside) + wander.complexity_penalty > cost_of_many
    return None if too_dear or not _explains_the_torque(plain, beside, wander) else (beside, rounds_beside)


def depends_on_more(problem: EquationErrorProblem, h: Hypothesis, at_most: float) -> bool:
    """Whether, with no wandering, a dependence on anything but the time leaves nothing of the torque, its price paid.

    Or hardly more of it than ``at_most``, in misfit per row. The ``problem`` is one in which nothing wanders.
    """
    f = fit(problem, h)
    problem = beside_generic_bases(problem, f)
    name = next((name for _, name in screen_generic_bases(problem, f) if dependence(name) != "time"), None)
    if name is None:
        return False
    columns = problem.generic_bases[name].shape[1]
    beside = fit(problem, h.with_generic_basis(name, columns))
    return (
        torque_left(beside) + CORRELATION * COST_OF_BASIS_COLUMN * columns / problem.size
        < at_most + MISFIT_DOUBTED - 1.0
    )


def _torque_cost(f: Fit) -> float:
    """What a hypothesis costs by the torque, as twice a negative log-likelihood, its price paid."""
    return float(f.problem.costs(f.raw)[: f.problem.size].sum()) / CORRELATION + complexity_penalty(f)


def torque_left(f: Fit) -> float:
    """What a row of torque adds to the misfit, in the mean: one where nothing but noise is left."""
    return float(f.problem.costs(f.raw)[: f.problem.size].mean())
