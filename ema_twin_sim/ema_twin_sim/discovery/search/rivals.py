"""Rivals: what could stand in for a found effect and explain the recordings as well."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ...criteria import CLEARLY_MORE, RIVAL_MARGIN, SMALL
from ...effects import Trait, catalogue, effects_with
from ...identification.candidates import candidates
from ...identification.comparable import as_compares, cheapest
from ...identification.compliance import structural_fits
from ...identification.fit import Fit, fit
from ...identification.hypothesis import COMPLIANT_EFFECTS, Hypothesis
from ...identification.local_minima import DAMPED, hopped, starting
from ...identification.screening import screen
from ...identification.unseen_encoders import parting_where_unseen
from ...model.roles import PLAY
from ..criteria.worth import ENCODER_ONLY, is_lacked, largest_rms_reduction, penalised_gain
from .adding import add_effects, prune, with_screened
from .trace import BEATEN, UNCERTAIN, Round, Search, Trial, new_names

SWAPS = 3


@dataclass(frozen=True, eq=False)
class Rivalry:
    """One found effect, the best that could stand in for it, and those that the data cannot tell from it."""

    effect: str
    runner_up: str  # empty: nothing else came near
    behind: float  # how much the runner-up loses by, in units of noise
    group: tuple[str, ...]  # the effect and what the data cannot tell from it, sorted
    fits: tuple[Fit, ...]  # the substitutes beside all other effects, best first

    def beside(self, end: Fit) -> Rivalry:
        """The rivalry with its substitutes under the weighting of an ``end`` that the search came to later."""
        return replace(self, fits=tuple(as_compares(f, end.problem) for f in self.fits))


def judged_against_rivals(found: Search, without: frozenset[str] = frozenset()) -> tuple[Search, tuple[Rivalry, ...]]:
    """The search with every effect that a rival beats replaced by it, and what still comes near.

    Effects ``without`` which it was made are no rivals.
    """
    rivals = rivalries(found, without)
    for _ in range(SWAPS):
        beaten = [
            rivalry
            for rivalry in rivals
            if rivalry.behind <= -_needed(found, rivalry) and not _farther(found.fit, rivalry.fits[0])
        ]
        better = max(beaten, key=lambda rivalry: -rivalry.behind, default=None)
        if better is None:
            break
        other = swapped(found, better.fits[0])
        if penalised_gain(found.fit, other.fit) <= 0.0:
            break  # the rival did not stay either
        found = with_displaced(found, other)
        rivals = rivalries(found, without)
    return found, rivals


def _needed(found: Search, rivalry: Rivalry) -> float:
    """By how much a rival must be better to take an effect's place: surely, where every machine has that effect.

    Where nothing reverses, friction is a constant load but for chance, and the model would be left without friction.
    """
    return RIVAL_MARGIN if is_lacked(found.fit.hypothesis, rivalry.effect) else 1.0


def with_displaced(before: Search, other: Search) -> Search:
    """The search after a rival took the place of an effect, with that effect where it is worth its price beside it."""
    held = before.fit.hypothesis.added
    back = {held[name].effect for name in new_names(other.fit, before.fit) if name in held}
    return other.further(*add_effects(other.fit, frozenset(catalogue()) - back, most=1))


def rivalries(found: Search, without: frozenset[str] = frozenset()) -> tuple[Rivalry, ...]:
    """For each effect of the end, what came near it when it was added, refitted in its place beside all the others."""
    best, problem = found.fit, found.problem
    judged = []
    for name, instance in best.hypothesis.added.items():
        turn = next((t for t in found.taken if name in t.added), None)
        compliant = instance.effect in COMPLIANT_EFFECTS
        if turn is None or (compliant and problem.size):
            continue
        if compliant:
            stands_in = other_structures(best, name, without)
        else:
            stands_in = [*substitutes(best, name, turn), *made_uncertain(found, name)]
            stands_in += not_asked_then(best, name, turn, without)
        fits = sorted(stands_in, key=lambda f: -penalised_gain(best, f))
        worth = [penalised_gain(best, f) for f in fits]
        effects = [list(f.hypothesis.added.values())[-1].effect for f in fits]
        close = {effect for effect, gained in zip(effects, worth, strict=True) if gained > -RIVAL_MARGIN}
        runner_up, behind = (effects[0], -worth[0]) if fits else ("", float("inf"))
        group = tuple(sorted({instance.effect, *close}))
        judged.append(Rivalry(instance.effect, runner_up, behind, group, tuple(fits)))
    return tuple(judged)


def substitutes(best: Fit, name: str, turn: Round) -> list[Fit]:
    """The end of the search with an effect replaced by each that came near it in its round."""
    winner = max(trial.gain for trial in turn.tried if name in trial.names)
    effect = best.hypothesis.added[name].effect
    return [
        fit(best.problem, h, 8, known=best)
        for other, h in came_near(best.hypothesis, name, turn, 0.5 * winner)
        if not ENCODER_ONLY & {effect, other}  # what no torque shows stands in for no torque
    ]


def came_near(best: Hypothesis, name: str, turn: Round, least: float) -> Iterator[tuple[str, Hypothesis]]:
    """The effects that alone gained ``least`` or more in a round, each with the hypothesis that has it in the place of
    the one called ``name``; what is there besides is not among them.
    """
    bare = best.without(name)
    for trial in turn.tried:
        held = trial.fit.hypothesis.added.keys()
        if len(trial.names) != 1 or trial.names[0] not in held or trial.gain < least:
            continue
        other = trial.fit.hypothesis.instance(trial.names[0])
        if other.effect not in best.effects:
            yield other.effect, bare.with_effect(other.effect, other.options, other.parameters)


def not_asked_then(best: Fit, name: str, turn: Round, without: frozenset[str]) -> list[Fit]:
    """The end of the search with an effect replaced by the best of those that its round could not ask for.

    While a gearbox is in doubt the torque is not asked for what that looks like; beside the play or spring that was
    found it can be: a constant load may stand where friction of the teeth belongs, which follows a weight.
    """
    if not best.parted or turn.before.parted:
        return []
    problem = best.problem
    bare = fit(problem, best.hypothesis.without(name), 8, known=best)
    like_gearbox = effects_with(Trait.LIKE_PLAY_OR_SPRING)
    options = [
        c
        for c in candidates(bare.hypothesis, without | {best.hypothesis.added[name].effect})
        if c.effect in like_gearbox
    ]
    ranked = [s for s in screen(problem, bare, options) if s.gain > SMALL * penalised_gain(bare, best)]
    gearbox = [other for other, held in best.hypothesis.added.items() if held.effect in COMPLIANT_EFFECTS]
    return [hopped(fit(problem, with_screened(problem, bare.hypothesis, s), 8), gearbox) for s in ranked[:1]]


def made_uncertain(found: Search, name: str) -> list[Fit]:
    """The end of the search with an effect replaced by each that was too uncertain beside it, and went.

    Two that take each other's place are both uncertain together, and the one that went may be the right one: over a
    part of a turn, a constant load beside the gravity that joined it later.
    """
    best = found.fit
    effect = best.hypothesis.added[name].effect
    bare = best.hypothesis.without(name)
    stands_in = []
    for turn in found.rounds:
        if turn.reason != UNCERTAIN or name not in turn.before.hypothesis.added:
            continue
        for gone in turn.removed:
            other = turn.before.hypothesis.instance(gone)
            if other.effect in best.hypothesis.effects or ENCODER_ONLY & {effect, other.effect}:
                continue
            if other.effect in COMPLIANT_EFFECTS:  # what it explains of the encoders says nothing of a torque
                continue
            beside = bare.with_effect(other.effect, other.options, other.parameters)
            stands_in.append(fit(best.problem, beside, 8, known=best))
    return stands_in


def other_structures(best: Fit, name: str, without: frozenset[str]) -> list[Fit]:
    """The end of a search of two encoders alone with play in the place of a spring, or a spring in that of play.

    A shaft that the output's friction winds up parts slow encoders as play does: what no torque tells apart, only fast
    motion does. None where both were found, or the other was not looked for (``without``).
    """
    effect = best.hypothesis.added[name].effect
    if {*COMPLIANT_EFFECTS} <= best.hypothesis.held:
        return []
    problem = best.problem
    bare = fit(problem, best.hypothesis.without(name))
    tried = structural_fits(problem, bare, without | {effect})
    found = []
    for f in tried:
        came = list(f.hypothesis.added)[-1]
        starts = [f.hypothesis]
        if effect == PLAY:  # of a spring and the friction that winds it up, slow motion tells but the ratio
            paths = (f"effects.{came}.stiffness", "scale.output_coulomb")
            starts = [starting(f.hypothesis, dict.fromkeys(paths, share)) for share in DAMPED]
        found.append(hopped(cheapest(fit(problem, h) for h in starts), [came]))
    # one that comes near, or gains, only by rows that count little is told apart where it was not fitted
    return [f for f in found if penalised_gain(best, f) <= -RIVAL_MARGIN or not _farther(best, f, CLEARLY_MORE)]


def _farther(best: Fit, rival: Fit, times: float = 1.0) -> bool:
    """Whether, of two encoders alone, a rival leaves them farther apart in recordings that it was not fitted to.

    Rows that are far off count little in a fit, and may be just where play parts from a spring: a rival that explains
    more of the others has not explained more.
    """
    return not best.problem.size and parting_where_unseen(rival) > times * parting_where_unseen(best)


def swapped(found: Search, rival: Fit, reason: str = BEATEN) -> Search:
    """The search with one more round, in which a rival took the place of one effect, or of several."""
    best, problem = found.fit, found.problem
    added, removed = new_names(best, rival), new_names(rival, best)
    bare = best.hypothesis
    for name in removed:
        bare = bare.without(name)
    nothing = fit(problem, bare, 8, known=best)
    tried = tuple(
        Trial(names, f, penalised_gain(nothing, f), largest_rms_reduction(problem, nothing, f))
        for names, f in ((added, rival), (removed, best))
        if names  # a rival may hold all that was there, and more
    )
    after = prune(fit(problem, rival.hypothesis))
    turn = Round(best, tried, after, added, removed, reason)
    return found.further(after, [turn])
