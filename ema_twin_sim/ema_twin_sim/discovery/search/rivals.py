"""Rivals: effects that could replace a found effect and explain the recordings as well."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from ...criteria import CLEARLY_MORE, DECIDED, RIVAL_MARGIN, SMALL
from ...effects import Trait, catalogue, effects_with
from ...identification.candidates import addable, candidates
from ...identification.comparable import as_compares, cheapest
from ...identification.compliance import structural_fits
from ...identification.fit import Fit, fit
from ...identification.hypothesis import COMPLIANT_EFFECTS, Hypothesis
from ...identification.loads_at_an_angle import is_load_at_an_angle, loads_at_an_angle
from ...identification.local_minima import DAMPED, hopped, starting
from ...identification.screening import screen
from ...identification.separation import beside_its_wander, encoders_tell_apart, separation
from ...identification.unseen_encoders import parting_where_unseen
from ...model.roles import PLAY
from ..criteria.opposed_loads import opposed
from ..criteria.plausible import uncertain
from ..criteria.worth import ENCODER_ONLY, does_nothing, is_lacked, largest_rms_reduction, penalised_gain
from .adding import add_effects, prune, with_screened
from .trace import BEATEN, SIMPLER, UNCERTAIN, Round, Search, Trial, new_names

SWAPS = 3


@dataclass(frozen=True, eq=False)
class Rivalry:
    """One found effect, its best rival, and the effects that the data cannot distinguish from it."""

    effect: str
    runner_up: str  # empty: no other effect was close
    behind: float  # how much the runner-up loses by, in units of noise
    close: Mapping[str, float]  # the effects that the data cannot distinguish from it: the odds of each against it
    fits: tuple[Fit, ...]  # the substitutes together with all other effects, best first

    @property
    def group(self) -> tuple[str, ...]:
        """The effect and those that the data cannot distinguish from it, sorted."""
        return tuple(sorted({self.effect, *self.close}))

    def beside(self, end: Fit) -> Rivalry:
        """The rivalry with its substitutes under the weighting of a later ``end`` of the search."""
        return replace(self, fits=tuple(as_compares(f, end.problem) for f in self.fits))


def undecided(rivals: Iterable[Rivalry]) -> tuple[tuple[str, ...], ...]:
    """The groups of effects that the data cannot tell apart.

    An effect that was found several times is certain as soon as one of them is.
    """
    rivals = tuple(rivals)
    certain = {rivalry.effect for rivalry in rivals if len(rivalry.group) == 1}
    return tuple(dict.fromkeys(rivalry.group for rivalry in rivals if rivalry.effect not in certain))


def judged_against_rivals(
    found: Search, without: frozenset[str] = frozenset(), *, beside_unknown: bool = False
) -> tuple[Search, tuple[Rivalry, ...]]:
    """Replace every effect that a rival beats; return the search and the rivals that are still close.

    Effects in ``without`` are no rivals. ``beside_unknown``: what is left unexplained decides between shapes that are
    nearly equal, so one with fewer parameters stands.
    """
    rivals = rivalries(found, without)
    for _ in range(SWAPS):
        other = _with_a_rival(found, rivals, beside_unknown=beside_unknown)
        if other is None:
            break
        found, rivals = other, rivalries(other, without)
    return found, rivals


def _with_a_rival(found: Search, rivals: Iterable[Rivalry], *, beside_unknown: bool) -> Search | None:
    """The search with the best rival that stays in the place of an effect that it beats, else with a simpler one.

    None if there is neither.
    """
    beaten = [
        rivalry
        for rivalry in rivals
        if rivalry.fits
        and rivalry.behind <= -_needed(found, rivalry)
        and not _farther(found.fit, rivalry.fits[0])
        and not (beside_unknown and _hardly_differ(_Leader(rivalry.fits[0]), found.fit, rivalry.effect))
        and _lasts(found.fit, rivalry.fits[0])
    ]
    for rivalry in sorted(beaten, key=lambda rivalry: rivalry.behind):
        other = swapped(found, rivalry.fits[0])
        if penalised_gain(found.fit, other.fit) > 0.0:
            return with_displaced(found, other)
    for rivalry in rivals if beside_unknown else ():
        for rival in _simpler(found.fit, rivalry):
            other = swapped(found, rival, SIMPLER)
            if opposed(other.fit) and not opposed(found.fit):
                continue  # two loads that cancel each other are a shape that neither of them is
            if {*new_names(found.fit, rival)} <= {*other.fit.hypothesis.added}:
                return other
    return None


def _lasts(best: Fit, rival: Fit) -> bool:
    """Whether what a rival has instead would not be removed again at once: it acts, and its numbers are certain."""
    new = new_names(best, rival)
    acts = not any(does_nothing(rival, name) for name in new if name in rival.hypothesis.added)
    return acts and {*uncertain(rival.problem, rival)}.isdisjoint(new)


def _needed(found: Search, rivalry: Rivalry) -> float:
    """By how much a rival must be better to replace an effect.

    By a clear margin if every machine has that effect: without a reversal, friction looks like a constant load except
    for chance, and the model would be left without friction. Likewise between loads at angles of their own, which are
    alike over a part of a turn: there chance alone would choose.
    """
    came = [*rivalry.fits[0].hypothesis.added.values()][-1]
    held = [instance for instance in found.fit.hypothesis.added.values() if instance.effect == rivalry.effect]
    alike = bool(held) and all(map(is_load_at_an_angle, (*held, came)))
    return RIVAL_MARGIN if alike or is_lacked(found.fit.hypothesis, rivalry.effect) else 1.0


def with_displaced(before: Search, other: Search) -> Search:
    """After a rival replaced an effect, add that effect again if it is worth its penalty in addition to the rival."""
    held = before.fit.hypothesis.added
    back = {held[name].effect for name in new_names(other.fit, before.fit) if name in held}
    return other.further(*add_effects(other.fit, frozenset(catalogue()) - back, most=1))


def rivalries(found: Search, without: frozenset[str] = frozenset()) -> tuple[Rivalry, ...]:
    """For each effect at the end: what was close when it was added, refitted in its place with all the others."""
    best, problem = found.fit, found.problem
    leader = _Leader(best)
    judged = []
    for name, instance in best.hypothesis.added.items():
        turn = next((t for t in found.taken if name in t.added), None)
        compliant = instance.effect in COMPLIANT_EFFECTS
        if turn is None or (compliant and problem.size):
            continue
        if compliant:
            stands_in = other_structures(best, name, without)
        else:
            stands_in = [*substitutes(best, name, turn), *loads_instead(best, name, without)]
            stands_in += made_uncertain(found, name)
            stands_in += not_asked_then(best, name, turn, without)
        fits = sorted(stands_in, key=lambda f: -penalised_gain(best, f))
        worth = [penalised_gain(best, f) for f in fits]
        effects = [list(f.hypothesis.added.values())[-1].effect for f in fits]
        close: dict[str, float] = {}
        for effect, rival, gained in zip(effects, fits, worth, strict=True):
            if gained > -RIVAL_MARGIN or _hardly_differ(leader, rival, instance.effect):
                close[effect] = max(close.get(effect, 0.0), leader.odds_of(rival, gained))
        runner_up, behind = (effects[0], -worth[0]) if fits else ("", float("inf"))
        judged.append(Rivalry(instance.effect, runner_up, behind, close, tuple(fits)))
    return tuple(judged)


def _simpler(best: Fit, rivalry: Rivalry) -> Iterator[Fit]:
    """The rivals that hardly differ from an effect and have fewer parameters, best first."""
    leader = _Leader(best)
    for rival in rivalry.fits:
        if len(rival.hypothesis.free) < len(best.hypothesis.free) and _hardly_differ(leader, rival, rivalry.effect):
            yield rival


class _Leader:
    """A fit that several rivals are compared with; what wanders beside it is estimated once, if that is asked."""

    def __init__(self, fit: Fit) -> None:
        self.fit = fit

    @cached_property
    def beside_its_wander(self) -> Fit:
        return beside_its_wander(self.fit) if self.fit.problem.size else self.fit

    def odds_of(self, rival: Fit, gained: float) -> float:
        """The odds of a rival that ``gained`` over this fit; those beside what wanders, if they are higher."""
        here = self.beside_its_wander
        beside = penalised_gain(here, as_compares(rival, here.problem))
        return math.exp(0.5 * min(max(gained, beside), DECIDED**2))


def _hardly_differ(leader: _Leader, rival: Fit, effect: str) -> bool:
    """Whether a rival may explain less of the torque only by chance, since friction that wanders is smooth as well.

    Not if it pulls constants from their file values or parts the encoders otherwise, whatever the torque tells, and not
    if the ``effect`` is one that every machine has and this model lacks: that one is there.
    """
    best = leader.fit
    if is_lacked(best.hypothesis, effect) or is_lacked(rival.hypothesis, effect):
        return False
    if not best.problem.size or abs(rival.prior_cost - best.prior_cost) > RIVAL_MARGIN:
        return False
    return not encoders_tell_apart(best, rival) and separation(leader.beside_its_wander, rival) < DECIDED


def substitutes(best: Fit, name: str, turn: Round) -> list[Fit]:
    """The end of the search with an effect replaced by each that was close to it in its round."""
    winner = max(trial.gain for trial in turn.tried if name in trial.names)
    effect = best.hypothesis.added[name].effect
    return [
        fit(best.problem, h, 8, known=best)
        for other, h in came_near(best.hypothesis, name, turn, 0.5 * winner)
        if not ENCODER_ONLY & {effect, other}  # an effect that does not show in the torque cannot replace one that does
    ]


def loads_instead(best: Fit, name: str, without: frozenset[str]) -> list[Fit]:
    """The end of the search with a load at an angle of its own replaced by each other one, at the angle it then has.

    The rounds did not try these: over a part of a turn, an arm acts as a spring that is relaxed where the arm hangs,
    wherever the recordings start. Effects in ``without`` are left out.
    """
    replaced = best.hypothesis.added[name]
    if not is_load_at_an_angle(replaced):
        return []
    bare = best.hypothesis.without(name)
    return [
        fit(best.problem, bare.with_effect(load.effect.id, load.options, {}), 8, known=best)
        for load in loads_at_an_angle(bare.base)
        if load.effect.id not in {replaced.effect, *without, *bare.effects} and addable(bare, load.effect.id)
    ]


def came_near(best: Hypothesis, name: str, turn: Round, least: float) -> Iterator[tuple[str, Hypothesis]]:
    """Effects that gained ``least`` or more alone in a round, each with the hypothesis that has it instead of ``name``.

    Effects that are already there are left out.
    """
    bare = best.without(name)
    for trial in turn.tried:
        held = trial.fit.hypothesis.added.keys()
        if len(trial.names) != 1 or trial.names[0] not in held or trial.gain < least:
            continue
        other = trial.fit.hypothesis.instance(trial.names[0])
        if other.effect not in best.effects and addable(bare, other.effect):
            yield other.effect, bare.with_effect(other.effect, other.options, other.parameters)


def not_asked_then(best: Fit, name: str, turn: Round, without: frozenset[str]) -> list[Fit]:
    """The end of the search with an effect replaced by the best of those that its round excluded.

    While a gearbox is in doubt, the search by torque excludes what looks like it. With the backlash or compliance
    found, these effects can be tried: a constant load may stand where friction of the teeth belongs, which follows a
    weight.
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
    """The end of the search with an effect replaced by each that was uncertain in its presence and was removed.

    Two effects that can replace each other are both uncertain together, and the removed one may be the right one: over
    part of a turn, a constant load in the presence of the gravity that was added later.
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
            if other.effect in best.hypothesis.effects or not addable(bare, other.effect):
                continue
            if ENCODER_ONLY & {effect, other.effect}:
                continue
            if other.effect in COMPLIANT_EFFECTS:  # what it explains of the encoders says nothing about a torque
                continue
            beside = bare.with_effect(other.effect, other.options, other.parameters)
            stands_in.append(fit(best.problem, beside, 8, known=best))
    return stands_in


def other_structures(best: Fit, name: str, without: frozenset[str]) -> list[Fit]:
    """With two encoders alone: the end of the search with backlash and compliance exchanged for each other.

    A shaft that the output's friction winds up separates slow encoders as backlash does; without torque data only fast
    motion distinguishes them. Empty if both were found, or if the other was excluded (``without``).
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
        if effect == PLAY:  # slow motion determines only the ratio of a stiffness to the friction that winds it up
            paths = (f"effects.{came}.stiffness", "scale.output_coulomb")
            starts = [starting(f.hypothesis, dict.fromkeys(paths, share)) for share in DAMPED]
        found.append(hopped(cheapest(fit(problem, h) for h in starts), [came]))
    # a rival that is close, or better, only through down-weighted rows is rejected by held-out recordings
    return [f for f in found if penalised_gain(best, f) <= -RIVAL_MARGIN or not _farther(best, f, CLEARLY_MORE)]


def _farther(best: Fit, rival: Fit, times: float = 1.0) -> bool:
    """Whether, with two encoders alone, a rival leaves a larger encoder difference on held-out recordings.

    Outliers have little weight in a fit, and may be exactly where backlash and compliance differ. A rival that explains
    more of the other rows has then not explained more.
    """
    return not best.problem.size and parting_where_unseen(rival) > times * parting_where_unseen(best)


def swapped(found: Search, rival: Fit, reason: str = BEATEN) -> Search:
    """The search with one more round, in which a rival replaced one effect or several."""
    best, problem = found.fit, found.problem
    added, removed = new_names(best, rival), new_names(rival, best)
    nothing = fit(problem, best.hypothesis.without(*removed), 8, known=best)
    tried = tuple(
        Trial(names, f, penalised_gain(nothing, f), largest_rms_reduction(problem, nothing, f))
        for names, f in ((added, rival), (removed, best))
        if names  # a rival may hold all that was there, and more
    )
    after = prune(fit(problem, rival.hypothesis))
    turn = Round(best, tried, after, added, removed, reason)
    return found.further(after, [turn])
