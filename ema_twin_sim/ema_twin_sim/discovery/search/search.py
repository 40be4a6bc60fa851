"""The search for the effects that a model lacks."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...criteria import (
    BESIDE_IMPACTS,
    CLEARLY_MORE,
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
from ..criteria.worth import ENCODER_ONLY, complexity_penalty
from .adding import add_effects, add_structure, added_and_removed, beside_impacts, settle
from .laws import under_best_laws
from .removing import significant
from .restarts import Restarts
from .trace import Round, Search


def parted_encoders(f: Fit) -> bool:
    """Whether motor and output encoder differ by more than their noise."""
    return any(
        p.stop > p.start and float(np.sqrt(np.mean(f.raw[p] ** 2))) > CLEARLY_MORE for p in f.problem.encoder_parts
    )


@dataclass(frozen=True)
class _Asked:
    """Inputs of a search: where it begins, and what its rounds may not add.

    ``by_torque`` are the effects excluded while only the torque is searched, ``without`` those that are always
    excluded. ``restarts`` collects the ends of searches that were restarted with wandering friction.
    """

    null: Hypothesis
    without: frozenset[str]
    by_torque: frozenset[str]
    progress: Callable[[str], None]
    restarts: Restarts


def search(
    problem: EquationErrorProblem,
    null: Hypothesis,
    without: frozenset[str] = frozenset(),
    progress: Callable[[str], None] = lambda text: None,
) -> Search:
    """Add effects to ``null``, each worth its complexity penalty, and remove those that later ones make needless.

    Each phase of a search has a limited number of rounds; with known constants a search stops at seven effects in all.
    If the encoders differ, the search is first by torque alone, then for backlash and compliance, then for everything
    together: a gearbox can only be simulated with the right loads. If what remains of the torque of a known machine is
    wandering friction, the search restarts with wandering as part of the noise.
    """
    bare = settle(fit(problem.under(problem.weighting.begun_anew(FAR)), null))
    if null.base.value("machine.output_inertia") == 0.0:
        without = without | set(COMPLIANT_EFFECTS)  # there is nothing behind the teeth
    if not problem.size:
        return _by_encoders_alone(bare, without, progress)
    parts = parted_encoders(bare) and not without >= {*COMPLIANT_EFFECTS, *ENCODER_ONLY}
    # effects that only the encoders show are considered only if the encoders differ
    by_torque = without | (_misleading(null) if parts else ENCODER_ONLY)
    if parts:
        progress("searching by torque alone")
    begun = fit(bare.problem.by_torque_alone(), bare.hypothesis) if parts else bare
    may_wander = begun.problem.weighting.wander is None and not null.base.is_open
    asked = _Asked(null, without, by_torque, progress, Restarts())
    current, rounds = _add_effects_or_wander(asked, begun, [], may_wander)
    if parts:
        current, rounds = _beside_encoders(asked, current, rounds, may_wander)
    return significant(under_best_laws(Search(current, tuple(rounds))))


def _misleading(null: Hypothesis) -> frozenset[str]:
    """Effects that the search by torque alone must exclude while the gearbox is in doubt."""
    return ENCODER_ONLY | effects_with(Trait.LIKE_PLAY_OR_SPRING) | (null.held & {*FRICTION})


def _beside_encoders(asked: _Asked, current: Fit, rounds: list[Round], may_wander: bool) -> tuple[Fit, list[Round]]:
    """Search for backlash and compliance after the search by torque, then for everything together.

    If a rigid drivetrain would need suspiciously many effects and wandering friction explains the torque instead, the
    encoders are searched with wandering as part of the noise.
    """
    # the search by torque has already tried wandering in place of so many effects
    may_wander = may_wander and current.problem.weighting.wander is None and not _many(current)
    current = fit(beside_impacts(current.problem.with_encoders()), current.hypothesis)
    if parted_encoders(current):
        current, rounds = _with_structure(asked, current, rounds, "trying play and compliance")
    if current.parted:
        return _beside_gearbox(asked, current, rounds, may_wander)
    before = current
    current, rounds = _add_effects_or_wander(asked, current, rounds, may_wander)
    if may_wander and current.problem.weighting.wander is not None:
        return _beside_encoders(asked, current, rounds, False)
    if _sensors(current) > _sensors(before) and parted_encoders(current):
        # what a gearbox leaves of the difference may be smaller than an encoder's error, which is known now
        said = "trying play and compliance beside the encoders' errors"
        current, rounds = _with_structure(asked, current, rounds, said)
    return _beside_gearbox(asked, current, rounds, may_wander) if current.parted else (current, rounds)


def _with_structure(asked: _Asked, current: Fit, rounds: list[Round], said: str) -> tuple[Fit, list[Round]]:
    """Add backlash, compliance or an encoder's error, whatever explains the encoders best; ``said`` is the progress."""
    asked.progress(said)
    current, turns = add_structure(current, asked.without)
    return current, [*rounds, *turns]


def _sensors(f: Fit) -> frozenset[str]:
    """The added errors of encoders."""
    return ENCODER_ONLY & {*f.hypothesis.effects}


def _beside_gearbox(asked: _Asked, current: Fit, rounds: list[Round], may_wander: bool) -> tuple[Fit, list[Round]]:
    """Add further effects once backlash or compliance is in the model, until none pays its complexity penalty.

    If wandering friction gains more than the first of them, they are searched with wandering as part of the noise,
    provided that this explains the torque. Without it, one friction curve after another would take its place.
    """
    after, first = add_effects(current, asked.without, asked.progress, most=1)
    if may_wander and first and first[0].added and (wander := _rather_wander(first[0])) is not None:
        asked.progress(
            f"friction seems to vary slowly by {wander.share:.1%}: searching on with that as part of the noise"
        )
        plain = current.problem
        problem = plain.under(replace(plain.weighting.begun_anew(BESIDE_IMPACTS), wander=wander))
        begun = settle(fit(problem, current.hypothesis))
        beside, more = add_effects(begun, asked.without, asked.progress)
        if explains_torque_with(wander, plain, beside):
            return beside, [*rounds, *more]
    if not first or not first[0].added:
        return current, [*rounds, *first]
    excluded = asked.without | added_and_removed(first)
    after, more = add_effects(after, excluded, asked.progress, most=MOST_EFFECTS - 1)
    return after, [*rounds, *first, *more]


def explains_torque_with(wander: Wander, plain: EquationErrorProblem, beside: Fit) -> bool:
    """Whether the torque is explained with wandering friction, and not as well by a dependence on something else."""
    left = torque_left(beside)
    paid = left + plain.correlation * wander.complexity_penalty / plain.size
    return left <= MISFIT_LEFT and not depends_on_more(plain, beside.hypothesis, paid)


def _by_encoders_alone(bare: Fit, without: frozenset[str], progress: Callable[[str], None]) -> Search:
    """The search without torque data: what lets the encoders differ, and errors of the encoders."""
    current = bare
    rounds: list[Round] = []
    # An encoder's error may be larger than the backlash, which shows only once that error is found.
    while len(rounds) < MOST_EFFECTS and parted_encoders(current) and not _gives_way(current):
        progress("trying play and compliance")
        current, turns = add_structure(current, without)
        rounds += turns
        if not turns[-1].added:
            break
    current, further = add_effects(current, without, progress)
    return significant(Search(current, (*rounds, *further)))


def _gives_way(f: Fit) -> bool:
    """Whether backlash or compliance was found."""
    return not {*f.hypothesis.effects}.isdisjoint(COMPLIANT_EFFECTS)


def _add_effects_or_wander(asked: _Asked, begun: Fit, rounds: list[Round], may_wander: bool) -> tuple[Fit, list[Round]]:
    """Add effects after ``rounds`` until none is worth its penalty; or restart by torque, with wandering friction.

    Each round tests for wandering until it is refused once. If wandering gains more by torque than the effect of the
    round, the search restarts with it. (While much is left, an effect's gain counts more than the same decrease of
    misfit does for wandering: effects come first.) Wandering is tested again if something is left at the end, or as
    soon as suspiciously many effects leave nothing. Further effects only lower the cost of the explanation without
    wandering, so what is refused with that many is refused with more.
    """
    later = bool(rounds)  # the residual of the torque alone was tested before
    without = asked.without if later else asked.by_torque
    if not may_wander:
        current, more = add_effects(begun, without, asked.progress)
        return current, [*rounds, *more]
    current, more = begun, []
    weaker, refused = later, False  # whether wandering explains less than one effect, and less than many
    while len(more) < MOST_EFFECTS:
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
    """How friction wanders, if that gains more by torque than the effect that a round took; else None."""
    wander = wandering(turn.before.problem, turn.before)
    took = next(trial for trial in turn.tried if trial.names == turn.added)
    return wander if wander is not None and wander.gain > took.gain else None


def _by_torque(f: Fit, later: bool) -> EquationErrorProblem:
    """The problem to test for wandering: the torque alone if the encoders were added ``later``."""
    return f.problem.by_torque_alone() if later else f.problem


def _many(f: Fit) -> bool:
    """Whether more effects that act on the torque were added than a machine may usually lack."""
    return sum(i.effect not in ENCODER_ONLY for i in f.hypothesis.added.values()) > USUAL_EFFECTS


def _beside_wander(
    asked: _Asked, plain: EquationErrorProblem, current: Fit, rounds: list[Round], wander: Wander | None = None
) -> tuple[Fit, list[Round]] | None:
    """End and rounds of a search restarted with wandering friction; None if that does not explain the torque.

    How friction wanders is given (``wander``), or estimated from the end of the search. If that end holds many effects,
    the fit after the second one is used instead: later effects hide the wandering.
    """
    if wander is None:
        taken = [turn.after for turn in rounds if turn.added]
        wander = wandering(plain, taken[1] if _many(current) and len(taken) > 1 else current)
    if wander is None:
        return None
    cost_of_many = torque_cost(current) if _many(current) else math.inf

    def restart() -> tuple[Fit, list[Round]]:
        asked.progress(
            f"friction seems to vary slowly by {wander.share:.1%}: starting again with that as part of the noise"
        )
        anew = plain.under(replace(plain.weighting.begun_anew(FAR), wander=wander))
        return add_effects(settle(fit(anew, asked.null)), asked.by_torque, asked.progress)

    beside, rounds_beside = asked.restarts(wander, plain.use_encoder, restart)
    too_dear = torque_cost(beside) + wander.complexity_penalty > cost_of_many
    return None if too_dear or not explains_torque_with(wander, plain, beside) else (beside, rounds_beside)


def depends_on_more(problem: EquationErrorProblem, h: Hypothesis, at_most: float) -> bool:
    """Whether, without wandering, a dependence on anything but time leaves nothing of the torque, its penalty included.

    Or hardly more than ``at_most``, in misfit per row. Nothing wanders in ``problem``.
    """
    f = fit(problem, h)
    problem = beside_generic_bases(problem, f)
    name = next((name for _, name in screen_generic_bases(problem, f) if dependence(name) != "time"), None)
    if name is None:
        return False
    columns = problem.generic_bases[name].shape[1]
    beside = fit(problem, h.with_generic_basis(name, columns))
    cost = torque_left(beside) + problem.correlation * COST_OF_BASIS_COLUMN * columns / problem.size
    return cost < at_most + MISFIT_DOUBTED - 1.0


def torque_cost(f: Fit) -> float:
    """Cost of a hypothesis by torque, as twice a negative log-likelihood including its complexity penalty."""
    return float(f.problem.costs(f.raw)[: f.problem.size].sum()) / f.problem.correlation + complexity_penalty(f)


def torque_left(f: Fit) -> float:
    """Mean misfit per torque row; one if only noise is left."""
    return float(f.problem.costs(f.raw)[: f.problem.size].mean())
