"""The search for the effects that a model lacks."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...criteria import (
    BESIDE_IMPACTS,
    CLEARLY_MORE,
    CORRELATION,
    COST_OF_BASIS_COLUMN,
    MISFIT_DOUBTED,
    MISFIT_LEFT,
    MOST_EFFECTS,
    NEARLY_ALL,
    USUAL_EFFECTS,
)
from ...effects import Trait, catalogue, effects_with
from ...identification.candidates import candidates
from ...identification.comparable import as_compares, cheapest, costs_no_more
from ...identification.compliance import structural_fits
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit, fits
from ...identification.generic_bases import beside_generic_bases, dependence
from ...identification.hypothesis import COMPLIANT_EFFECTS, Hypothesis
from ...identification.local_minima import hopped
from ...identification.screening import Screened, screen, screen_generic_bases
from ...identification.sensors import gearbox_shows
from ...identification.wandering import wandering
from ...identification.weighting import FAR
from ...model.roles import FRICTION, TORQUE_FACTOR
from ...parallel import predictions
from ..criteria.plausible import insignificant
from ..criteria.worth import (
    ENCODER_ONLY,
    complexity_penalty,
    has_effect_size,
    is_lacked,
    largest_rms_reduction,
    penalised_gain,
)
from .found_orders import order_candidates, resolved
from .trace import BEATEN, NEEDLESS, UNCERTAIN, WANDERS, Round, Search, Trial, new_names

ENTRANTS = 8  # effects that are fitted in a round, of all that were screened
SECOND_LOOKS = 2  # trials that are fitted in full before a round is given up
NEXT_TO_NOTHING = 1e-3  # of an effect's size


def settle(f: Fit) -> Fit:
    """Take weight from outliers, fit again: the fit under a weighting that suits what it leaves over."""
    for _ in range(4):
        weighting = f.problem.reweighed(f.raw, BESIDE_IMPACTS if f.parted else math.inf).inflated(f.variance_inflation)
        if weighting is f.problem.weighting:
            break
        f = fit(f.problem.under(weighting), f.hypothesis)
    return f


def parted_encoders(f: Fit) -> bool:
    """Whether the encoders part by more than their noise."""
    return any(
        p.stop > p.start and float(np.sqrt(np.mean(f.raw[p] ** 2))) > CLEARLY_MORE for p in f.problem.encoder_parts
    )


def search(
    problem: EquationErrorProblem,
    null: Hypothesis,
    without: frozenset[str] = frozenset(),
    progress: Callable[[str], None] = lambda text: None,
    most: int = MOST_EFFECTS,
    may_wander: bool = True,
) -> Search:
    """Add effects to ``null``, each worth its price, and drop what later ones make needless.

    In each of its phases a search goes ``most`` rounds.
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
    current, rounds = _add_effects_or_wander(null, begun, [], by_torque, by_torque, progress, most, may_wander)
    if parts:
        current, rounds = _beside_encoders(null, current, rounds, without, by_torque, progress, most, may_wander)
    return significant(Search(current, tuple(rounds)))


def _beside_encoders(
    null: Hypothesis,
    current: Fit,
    rounds: list[Round],
    without: frozenset[str],
    by_torque: frozenset[str],
    progress: Callable[[str], None],
    most: int,
    may_wander: bool,
) -> tuple[Fit, list[Round]]:
    """What the torque alone told, then play and spring, then all together.

    Where a rigid train would take suspiciously many effects and wandering explains the torque instead, the encoders are
    asked beside that.
    """
    # of what the torque alone took so many effects for, it was asked already
    may_wander = may_wander and current.problem.weighting.wander is None and not _many(current)
    current = fit(_beside_impacts(current.problem.with_encoders()), current.hypothesis)
    if parted_encoders(current):
        progress("looking at the gearbox")
        current, by_gearbox = _add_structure(current, without)
        rounds = [*rounds, *by_gearbox]
    may_wander = may_wander and not current.parted
    current, rounds = _add_effects_or_wander(null, current, rounds, without, by_torque, progress, most, may_wander)
    if may_wander and current.problem.weighting.wander is not None:
        return _beside_encoders(null, current, rounds, without, by_torque, progress, most, False)
    return current, rounds


def _beside_impacts(problem: EquationErrorProblem) -> EquationErrorProblem:
    """The problem under the weighting that play and springs are looked for under."""
    return problem.under(problem.weighting.from_outliers(BESIDE_IMPACTS))


def _by_encoders_alone(bare: Fit, without: frozenset[str], progress: Callable[[str], None], most: int) -> Search:
    """The search where no torque was measured: what lets the encoders part, and what is amiss with them."""
    current = bare
    rounds: list[Round] = []
    # an encoder's error may be larger than the play beside it, which shows once that error is found
    while len(rounds) < most and parted_encoders(current) and not _gives_way(current):
        progress("looking at the gearbox")
        current, turns = _add_structure(current, without)
        rounds += turns
        if not turns[-1].added:
            break
    current, further = add_effects(current, without, progress, most=most)
    return significant(Search(current, (*rounds, *further)))


def _gives_way(f: Fit) -> bool:
    """Whether play or a spring was found."""
    return not {*f.hypothesis.effects}.isdisjoint(COMPLIANT_EFFECTS)


def _add_effects_or_wander(
    null: Hypothesis,
    begun: Fit,
    rounds: list[Round],
    without: frozenset[str],
    by_torque: frozenset[str],
    progress: Callable[[str], None],
    most: int,
    may_wander: bool,
) -> tuple[Fit, list[Round]]:
    """More effects after ``rounds``, until none is worth its price; or anew, ``by_torque``, beside wandering friction.

    Wandering is asked for where something is left of the torque alone, or as soon as it takes suspiciously many effects
    to leave nothing. More of them only make what they explain cheaper: what is refused beside that many is refused
    beside more.
    """
    if not may_wander:
        current, more = add_effects(begun, without, progress, most=most)
        return current, [*rounds, *more]
    later = bool(rounds)  # what the torque alone leaves was asked before
    first = min(most, max(USUAL_EFFECTS + 1 - len(begun.hypothesis.added), 1))
    current, more = add_effects(begun, without, progress, most=first)
    refused = False
    if len(more) == first and more[-1].added:
        if _many(current):
            beside = _beside_wander(
                null, _by_torque(current, later), current, [*rounds, *more], by_torque, progress, most
            )
            if beside is not None:
                return beside
            refused = True
        current, rest = add_effects(current, without | _added_and_removed(more), progress, most=most - first)
        more += rest
    rounds = [*rounds, *more]
    many = _many(current)
    if (refused and many) or not (many or (torque_left(current) > MISFIT_LEFT and not later)):
        return current, rounds
    plain = _by_torque(current, later)
    return _beside_wander(null, plain, current, rounds, by_torque, progress, most) or (current, rounds)


def _by_torque(f: Fit, later: bool) -> EquationErrorProblem:
    """The problem that is asked for wandering: of the torque alone where the encoders' part came ``later``."""
    return f.problem.by_torque_alone() if later else f.problem


def _many(f: Fit) -> bool:
    """Whether more effects that a torque shows were added than a machine may usually lack."""
    return sum(i.effect not in ENCODER_ONLY for i in f.hypothesis.added.values()) > USUAL_EFFECTS


def _beside_wander(
    null: Hypothesis,
    plain: EquationErrorProblem,
    current: Fit,
    rounds: list[Round],
    without: frozenset[str],
    progress: Callable[[str], None],
    most: int,
) -> tuple[Fit, list[Round]] | None:
    """The end and the rounds begun anew beside friction that wanders; None where that does not explain the torque."""
    taken = [turn.after for turn in rounds if turn.added]
    wander = wandering(plain, taken[1] if _many(current) and len(taken) > 1 else current)  # before many hid it
    if wander is None:
        return None
    cost_of_many = _torque_cost(current) if _many(current) else math.inf
    progress(f"friction seems to wander by {wander.share:.1%}: beginning anew beside that")
    anew = plain.under(replace(plain.weighting.begun_anew(FAR), wander=wander))
    beside, rounds_beside = add_effects(settle(fit(anew, null)), without, progress, most=most)
    left = torque_left(beside)
    too_dear = _torque_cost(beside) + wander.complexity_penalty > cost_of_many
    paid = left + CORRELATION * wander.complexity_penalty / plain.size
    if left > MISFIT_LEFT or too_dear or depends_on_more(plain, beside.hypothesis, paid):
        return None
    return beside, rounds_beside


def _added_and_removed(rounds: Iterable[Round]) -> frozenset[str]:
    """Effects that went as soon as they came."""
    return frozenset(turn.effect_of(name) for turn in rounds for name in turn.removed if name in turn.added)


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


def significant(found: Search) -> Search:
    """The search less what is not sure to be there; with what had made room for that."""
    while name := insignificant(found.problem, found.fit):
        found = with_what_made_room(less(found, [name], UNCERTAIN))
    return found


def with_what_made_room(found: Search) -> Search:
    """The search with what was needless beside something that is no longer there, where it is worth its price again.

    And with an encoder's own error where that something came in its place, and with what wandering friction explained
    beside play or a spring that is gone. What was taken out for a reason of its own does not come back.
    """
    reasons = {NEEDLESS} if found.fit.parted else {NEEDLESS, WANDERS}  # which is asked beside play and springs alone
    once = {turn.effect_of(gone) for turn in found.rounds if turn.reason in reasons for gone in turn.removed}
    held = {*found.fit.hypothesis.added}
    for turn in found.taken:
        if held.isdisjoint(turn.added):
            once |= ENCODER_ONLY & {e for trial in turn.tried if trial.gain > 0.0 for e in trial.fit.hypothesis.effects}
    for turn in found.rounds:
        if turn.reason not in reasons:
            went = turn.before.hypothesis.added
            once -= {went[name].effect for name in turn.removed if name in went}
    back = (once & catalogue().keys()) - {*found.fit.hypothesis.effects}
    if not back:
        return found
    return found.further(*add_effects(found.fit, frozenset(catalogue()) - back, most=len(back)))


def less(found: Search, names: Sequence[str], reason: str) -> Search:
    """The search with one more round, in which effects were taken out, and what is needless without them.

    What gave its place to them as better rivals has it back: the end is the one before that.
    """
    if not names:
        return found
    if (before := _before_swap(found, names)) is not None:
        return found.ended(before, reason)
    h = found.fit.hypothesis
    for name in names:
        h = _without(h, name)
    return found.ended(prune(settle(fit(found.problem, h))), reason)


def _before_swap(found: Search, names: Sequence[str]) -> Fit | None:
    """The end before effects of these ``names`` took the place of others; None where more has gone since then."""
    last = next((turn for turn in reversed(found.changes) if turn.reason != NEEDLESS), None)
    return last.before if last is not None and last.reason == BEATEN and {*names} <= {*last.added} else None


def _misleading(null: Hypothesis) -> frozenset[str]:
    """Effects that the torque alone must not be asked for while the gearbox is in doubt."""
    return ENCODER_ONLY | effects_with(Trait.LIKE_PLAY_OR_SPRING) | (null.held & {*FRICTION})


def add_effects(
    current: Fit,
    without: frozenset[str],
    progress: Callable[[str], None] = lambda text: None,
    most: int = MOST_EFFECTS,
) -> tuple[Fit, list[Round]]:
    """One effect a round, until none is worth its price."""

    def entering(current: Fit, excluded: frozenset[str]) -> list[Fit]:
        progress("trying all effects")
        entering = entrants(current.problem, current, without | excluded)
        current.differentiate()  # once, for all of them
        return list(predictions(current.problem.samples, lambda h: with_one_more(current, h), entering))

    return add_best(current, entering, most, progress)


def add_best(
    current: Fit,
    entering: Callable[[Fit, frozenset[str]], Sequence[Fit]],
    most: int,
    progress: Callable[[str], None] = lambda text: None,
) -> tuple[Fit, list[Round]]:
    """The best of those ``entering`` a round, until none is worth its price; less what went as soon as it came."""
    rounds: list[Round] = []
    excluded: frozenset[str] = frozenset()
    for _ in range(most):
        if len(current.hypothesis.added) >= MOST_EFFECTS and not current.hypothesis.base.is_open:
            break  # what takes more of them is something else
        turn = take_best(current, entering(current, excluded))
        rounds.append(turn)
        if not turn.added:
            break
        progress("found " + " and ".join(turn.added))
        excluded |= _added_and_removed([turn])
        current = turn.after
    return current, rounds


def with_one_more(current: Fit, h: Hypothesis) -> Fit:
    """A fit of a hypothesis that has one effect more, from where a regression would start it.

    Or, if a straight line led too far, from a typical size, or from where the effect does next to nothing.
    """
    name = next(n for n in h.added if n not in current.hypothesis.added)
    size = catalogue()[h.added[name].effect].parameters[0]
    tried = [fit(current.problem, h, 6, known=current)]
    begun = h.instance(name).parameters[size.name]
    if size.neutral is not None:
        for value in (size.default, size.neutral + NEXT_TO_NOTHING * (begun - size.neutral)):
            if costs_no_more(tried[-1], current):
                break
            near = h.put({**current.hypothesis.by_path, f"effects.{name}.{size.name}": value})
            tried.append(fit(current.problem, near, 6, known=current))
    return cheapest(tried)


def _add_structure(current: Fit, without: frozenset[str]) -> tuple[Fit, list[Round]]:
    """Play, spring, both, or an encoder that is late or off its centre: whatever explains the encoders best."""
    tried, problem = [], current.problem
    if gearbox_shows(problem, current):
        tried = structural_fits(problem, current, without)
        problem = _beside_impacts(problem)
    by_torque = frozenset(
        c.effect for c in candidates(current.hypothesis) if catalogue()[c.effect].depends_on != "encoders"
    )
    tried += fits(problem, entrants(problem, current, without | by_torque), 6)
    turn = take_best(as_compares(current, problem), tried)
    return turn.after if turn.added else current, [turn]


def take_best(current: Fit, tried: Sequence[Fit]) -> Round:
    """Take the best of what was tried, if it is worth its price, and drop what it makes needless."""
    choices = Counter(c.effect for c in candidates(current.hypothesis))
    trials = _ranked((trial_of(current, g) for g in tried), choices)
    took = _best(current, trials)
    if took is None and not current.parted:
        # a trial keeps the slopes of what was there before: what is worth its price, but small, deserves its own
        near = [t for t in trials if t.gain > 0.0][:SECOND_LOOKS]
        whole = predictions(current.problem.samples, lambda t: fit(t.fit.problem, t.fit.hypothesis), near)
        again = [trial_of(current, f) for f in whole]
        trials = _ranked([*again, *(t for t in trials if t not in near)], choices)
        took = _best(current, trials)
    if took is None:
        return Round(current, trials, current)
    balanced = fit(took.fit.problem, took.fit.hypothesis.balanced())
    fresh = [name for name in took.names if name in balanced.hypothesis.added]
    after = prune(settle(hopped(balanced, fresh) if balanced.parted else balanced))
    return Round(current, trials, after, took.names, new_names(after, took.fit))


def trial_of(before: Fit, after: Fit) -> Trial:
    """What a fit holds that another has not, and what that gains."""
    problem = before.problem
    return Trial(
        new_names(before, after),
        after,
        penalised_gain(before, after),
        largest_rms_reduction(problem, before, after),
    )


def _ranked(trials: Iterable[Trial], choices: Mapping[str, int]) -> tuple[Trial, ...]:
    """Best first; a generic basis fits anything: an effect that does nearly as well goes before it.

    So does, before any other effect, what every machine has and this model lacks: where nothing reverses, friction is
    a load, and a load would be no friction. And of two that do equally well, the one that had fewer ``choices`` of its
    options to be the best of.
    """
    return tuple(sorted(trials, key=lambda t: _by_choice(t, choices) - t.gain * _favour(t)))


def _by_choice(t: Trial, choices: Mapping[str, int]) -> float:
    """What the best of several choices gains by chance, as twice a log-likelihood."""
    came = (t.fit.hypothesis.added[name].effect for name in t.names if name in t.fit.hypothesis.added)
    return sum(2.0 * math.log(max(choices.get(id, 1), 1)) for id in came)


def _favour(t: Trial) -> float:
    h = t.fit.hypothesis
    if {*t.names} & {*h.generic_bases}:
        return NEARLY_ALL
    return 1.0 / NEARLY_ALL if all(is_lacked(h, h.added[name].effect) for name in t.names) else 1.0


def _best(current: Fit, trials: Iterable[Trial]) -> Trial | None:
    """The first that is worth its price, and large enough to be named."""
    return next((t for t in trials if t.gain > 0.0 and has_effect_size(current.problem, current, t.fit)), None)


def entrants(problem: EquationErrorProblem, current: Fit, without: frozenset[str]) -> list[Hypothesis]:
    """The current hypothesis with each of the most promising effects added."""
    options = [c for c in candidates(current.hypothesis, without) if c.effect not in COMPLIANT_EFFECTS]
    options += [c for c in order_candidates(problem, current) if c.effect not in without]
    ranked = screen(problem, current, resolved(problem, options, current.hypothesis.base))
    picked: list[Screened] = []
    for s in ranked:
        alike = sum(p.candidate.effect == s.candidate.effect for p in picked)
        if alike < 2 and len(picked) < ENTRANTS and s.gain > (1.0 - NEARLY_ALL) * ranked[0].gain:
            picked.append(s)
    return [with_screened(problem, current.hypothesis, s) for s in picked]


def with_screened(problem: EquationErrorProblem, h: Hypothesis, s: Screened) -> Hypothesis:
    """A hypothesis with one effect more, from where a regression would have it and the others make room for it."""
    lower, upper = problem.bounds(h)
    room = h.at(np.clip(h.values + s.give_way(), lower, upper))
    return room.with_effect(s.candidate.effect, s.candidate.options, s.start)


def prune(f: Fit, certain: float = math.inf) -> Fit:
    """Take out effects that are not, or no longer, worth their price, the last added included.

    A generic basis fits anything: beside it, what every machine has and the model lacked stays. So does, however small
    it is, an effect that gains more than ``certain``.
    """
    problem = f.problem
    while f.hypothesis.added or f.hypothesis.generic_bases:
        h = f.hypothesis
        names = [n for n in h.added if not (h.generic_bases and is_lacked(h, h.added[n].effect))]
        trials = [*zip(names, _less_each(f, names), strict=True)]
        less = [h.without_generic_basis(n) for n in h.generic_bases]
        trials += zip(h.generic_bases, fits(problem, less, 4, known=f), strict=True)
        needless = [
            g
            for n, g in trials
            if (lost := -penalised_gain(f, g)) <= 0.0
            or (lost <= certain and not (_on_the_other_side(h, n) or has_effect_size(problem, g, f)))
        ]
        if not needless:
            break
        best = max(needless, key=lambda g: penalised_gain(f, g))
        f = fit(problem, best.hypothesis) if best.parted else best  # a trial beside a gearbox is to first order
    return f


def _less_each(f: Fit, names: Sequence[str]) -> list[Fit]:
    """Fits less one of the added effects each.

    To first order in what stays; but where play and a spring are there, each takes the other's place in its own way.
    """
    less = fits(f.problem, [_without(f.hypothesis, n) for n in names], 6, known=f)
    compliant = [k for k, n in enumerate(names) if f.hypothesis.added[n].effect in COMPLIANT_EFFECTS]
    if len(compliant) > 1:
        for k, whole in zip(compliant, fits(f.problem, [less[k].hypothesis for k in compliant]), strict=True):
            less[k] = whole
    return less


def _on_the_other_side(h: Hypothesis, name: str) -> bool:
    """Whether an added friction is one that every machine has, found on both sides of play or a spring.

    The torque shows the sum of both; how they are shared, which winds the spring up and holds the output within the
    gap, the encoders show.
    """
    alike = [i.effect for i in h.added.values() if name in h.added and i.effect == h.added[name].effect]
    return len(alike) > 1 and catalogue()[alike[0]].every_machine


def _without(h: Hypothesis, name: str) -> Hypothesis:
    """A hypothesis less one effect, from where the others make up for it."""
    instance = h.instance(name)
    rest = h.without(name)
    if instance.effect != TORQUE_FACTOR:
        return rest
    return rest.with_torques_times(1.0 / instance.parameters["scale"])
