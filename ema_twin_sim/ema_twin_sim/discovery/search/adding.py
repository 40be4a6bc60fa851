"""Adding: one effect a round. Which effects are tried, which is taken, and what becomes needless."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from ...criteria import BESIDE_IMPACTS, DEPENDS, MOST_EFFECTS, MOSTLY, NEARLY_ALL
from ...effects import Trait, catalogue, effects_with
from ...identification.candidates import candidates
from ...identification.comparable import as_compares, cheapest, costs_no_more
from ...identification.compliance import structural_fits
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit, fits
from ...identification.hypothesis import COMPLIANT_EFFECTS, Hypothesis
from ...identification.local_minima import hopped
from ...identification.screening import Screened, screen
from ...identification.sensors import gearbox_shows
from ...model.own_units import table_in
from ...model.roles import TORQUE_FACTOR
from ...parallel import predictions
from ..criteria.worth import (
    does_nothing,
    has_effect_size,
    is_lacked,
    largest_rms_reduction,
    penalised_gain,
    standing_on,
)
from .found_orders import order_candidates, resolved
from .laws import with_best_laws
from .trace import Round, Trial, new_names

ENTRANTS = 8  # effects that are fitted in a round, of all that were screened
SECOND_LOOKS = 2  # trials that are fitted in full before a round gives up
NEXT_TO_NOTHING = 1e-3  # of an effect's size


def settle(f: Fit) -> Fit:
    """Down-weight outliers and fit again until the weighting suits the residual."""
    for _ in range(4):
        weighting = f.problem.reweighed(f.raw, BESIDE_IMPACTS if f.parted else math.inf).inflated(f.variance_inflation)
        if weighting is f.problem.weighting:
            break
        f = fit(f.problem.under(weighting), f.hypothesis)
    return f


def beside_impacts(problem: EquationErrorProblem) -> EquationErrorProblem:
    """The problem with the weighting used to search for backlash and compliance."""
    return problem.under(problem.weighting.from_outliers(BESIDE_IMPACTS))


def add_effects(
    current: Fit,
    without: frozenset[str],
    progress: Callable[[str], None] = lambda text: None,
    most: int = MOST_EFFECTS,
) -> tuple[Fit, list[Round]]:
    """One effect a round, until none is worth its complexity penalty."""

    def entering(current: Fit, excluded: frozenset[str]) -> list[Fit]:
        progress("trying all effects")
        entering = entrants(current.problem, current, without | excluded)
        current.differentiate()  # once for all of them
        return list(predictions(current.problem.samples, lambda h: with_one_more(current, h), entering))

    return add_best(current, entering, most, progress)


def add_best(
    current: Fit,
    entering: Callable[[Fit, frozenset[str]], Sequence[Fit]],
    most: int,
    progress: Callable[[str], None],
) -> tuple[Fit, list[Round]]:
    """Add the best of those ``entering`` in each round until none is worth its penalty.

    An effect that is removed in the round that added it is not tried again.
    """
    rounds: list[Round] = []
    excluded: frozenset[str] = frozenset()
    for _ in range(most):
        if len(current.hypothesis.added) >= MOST_EFFECTS and not current.hypothesis.base.is_open:
            break  # a cause that needs more effects is something else
        turn = take_best(current, entering(current, excluded))
        rounds.append(turn)
        if not turn.added:
            break
        progress("found " + " and ".join(turn.added))
        excluded |= added_and_removed([turn])
        current = turn.after
    return current, rounds


def with_one_more(current: Fit, h: Hypothesis) -> Fit:
    """Fit of a hypothesis with one more effect, from the start value given by a regression.

    If the linear estimate went too far, start from a typical size, or from almost no effect.
    """
    name = next(n for n in h.added if n not in current.hypothesis.added)
    size = table_in(catalogue()[h.added[name].effect], h.base.units).parameters[0]
    tried = [fit(current.problem, h, 6, known=current)]
    begun = h.instance(name).parameters[size.name]
    if size.neutral is not None:
        for value in (size.default, size.neutral + NEXT_TO_NOTHING * (begun - size.neutral)):
            if costs_no_more(tried[-1], current):
                break
            near = h.put({**current.hypothesis.by_path, f"effects.{name}.{size.name}": value})
            tried.append(fit(current.problem, near, 6, known=current))
    return cheapest(tried)


def add_structure(current: Fit, without: frozenset[str]) -> tuple[Fit, list[Round]]:
    """Backlash, compliance, both, or a late or eccentric encoder: whatever explains the encoders best."""
    tried, problem = [], current.problem
    if gearbox_shows(problem, current):
        tried = structural_fits(problem, current, without)
        problem = beside_impacts(problem)
    by_torque = frozenset(
        c.effect for c in candidates(current.hypothesis) if catalogue()[c.effect].depends_on != "encoders"
    )
    tried += fits(problem, entrants(problem, current, without | by_torque), 6)
    turn = take_best(as_compares(current, problem), tried)
    return turn.after if turn.added else current, [turn]


def take_best(current: Fit, tried: Sequence[Fit]) -> Round:
    """Take the best trial if it is worth its penalty, and remove what it makes needless."""
    choices = Counter(c.effect for c in candidates(current.hypothesis))
    trials = _ranked((trial_of(current, g) for g in tried), choices)
    took = _best(current, trials)
    if took is None and not current.parted:
        # A trial keeps the slopes of the earlier effects; a small one that is worth its penalty gets a full fit.
        near = [t for t in trials if t.gain > 0.0][:SECOND_LOOKS]
        whole = predictions(current.problem.samples, lambda t: fit(t.fit.problem, t.fit.hypothesis), near)
        again = [trial_of(current, f) for f in whole]
        trials = _ranked([*again, *(t for t in trials if t not in near)], choices)
        took = _best(current, trials)
    if took is None:
        return Round(current, trials, current)
    balanced = fit(took.fit.problem, took.fit.hypothesis.balanced())
    fresh = [name for name in took.names if name in balanced.hypothesis.added]
    settled = settle(hopped(balanced, fresh) if balanced.parted else balanced)
    if not current.parted:  # beside a gearbox that is there already, once at the end of the search
        settled = with_best_laws(settled)
    after = prune(settled)
    return Round(current, trials, after, took.names, new_names(after, took.fit))


def trial_of(before: Fit, after: Fit) -> Trial:
    """The effects that ``after`` has and ``before`` has not, and what they gain."""
    unique = largest_rms_reduction(before.problem, before, after)
    return Trial(new_names(before, after), after, penalised_gain(before, after), unique)


def _ranked(trials: Iterable[Trial], choices: Mapping[str, int]) -> tuple[Trial, ...]:
    """Best first. A generic basis fits anything, so an effect that does nearly as well goes before it.

    An effect that every machine has and this model lacks goes before any other effect: without a reversal, friction
    looks like a load, and a load would leave the model without friction. Of two equal trials, the one with fewer
    ``choices`` of options goes first.
    """
    return tuple(sorted(trials, key=lambda t: _by_choice(t, choices) - t.gain * _favour(t)))


def _by_choice(t: Trial, choices: Mapping[str, int]) -> float:
    """Gain by chance of the best of several choices, as twice a log-likelihood."""
    return sum(2.0 * math.log(max(choices.get(id, 1), 1)) for id in _came(t))


def _favour(t: Trial) -> float:
    h = t.fit.hypothesis
    if {*t.names} & {*h.generic_bases}:
        return NEARLY_ALL
    return 1.0 / NEARLY_ALL if all(is_lacked(h, h.added[name].effect) for name in t.names) else 1.0


def _best(current: Fit, trials: Sequence[Trial]) -> Trial | None:
    """The first trial that is worth its penalty and large enough to be named."""
    worth = (t for t in trials if t.gain > 0.0 and not _too_quick(t, trials))
    return next((t for t in worth if has_effect_size(current.problem, current, t.fit)), None)


def _too_quick(trial: Trial, trials: Sequence[Trial]) -> bool:
    """Whether friction turns round faster than the recordings resolve, so that no law by which it does can be told.

    A bristle so stiff that it does nothing between two samples then gains about as much: only how the samples fall
    around a reversal is fitted. Without a bristle among the trials, that cannot be told.
    """
    laws = effects_with(Trait.ACTS_AT_REVERSALS)
    if laws.isdisjoint(_came(trial)):
        return False
    others = (t for t in trials if t.gain > MOSTLY * trial.gain and not laws.isdisjoint(_came(t)))
    return any(does_nothing(t.fit, name) for t in others for name in t.names if name in t.fit.hypothesis.added)


def _came(t: Trial) -> tuple[str, ...]:
    """The effects that a trial adds."""
    added = t.fit.hypothesis.added
    return tuple(added[name].effect for name in t.names if name in added)


def entrants(problem: EquationErrorProblem, current: Fit, without: frozenset[str]) -> list[Hypothesis]:
    """The current hypothesis with each of the most promising effects added."""
    options = [c for c in candidates(current.hypothesis, without) if c.effect not in COMPLIANT_EFFECTS]
    options += order_candidates(problem, current, without)
    ranked = screen(problem, current, resolved(problem, options, current.hypothesis.base))
    picked: list[Screened] = []
    for s in ranked:
        alike = sum(p.candidate.effect == s.candidate.effect for p in picked)
        if alike < 2 and len(picked) < ENTRANTS and s.gain > (1.0 - NEARLY_ALL) * ranked[0].gain:
            picked.append(s)
    return [with_screened(problem, current.hypothesis, s) for s in picked]


def with_screened(problem: EquationErrorProblem, h: Hypothesis, s: Screened) -> Hypothesis:
    """Hypothesis with one more effect, at its regressed start; the other effects are adjusted for it."""
    lower, upper = problem.bounds(h)
    room = h.at(np.clip(h.values + s.give_way(), lower, upper))
    return room.with_effect(s.candidate.effect, s.candidate.options, s.start)


def prune(f: Fit) -> Fit:
    """Remove effects that are not, or no longer, worth their penalty, the last added included.

    A generic basis fits anything: in its presence, an effect that every machine has and the model lacked stays. So does
    dry friction on which other friction stands. With wandering friction, which has absorbed some of it, an effect that
    still gains clearly also stays, however small.
    """
    problem = f.problem
    certain = math.inf if problem.weighting.wander is None else DEPENDS
    while f.hypothesis.added or f.hypothesis.generic_bases:
        h = f.hypothesis
        names = [
            n for n in h.added if not (h.generic_bases and is_lacked(h, h.added[n].effect)) and not standing_on(h, n)
        ]
        trials = [*zip(names, less_each(f, names), strict=True)]
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
        f = fit(problem, best.hypothesis) if best.parted else best  # a trial was to first order only
    return f


def less_each(f: Fit, names: Sequence[str]) -> list[Fit]:
    """Fits without each of the named effects in turn.

    To first order in the effects that stay. If both backlash and compliance are there, these are fitted in full, since
    each replaces the other in its own way.
    """
    less = fits(f.problem, [without_effect(f.hypothesis, n) for n in names], 6, known=f)
    compliant = [k for k, n in enumerate(names) if f.hypothesis.added[n].effect in COMPLIANT_EFFECTS]
    if len(compliant) > 1:
        for k, whole in zip(compliant, fits(f.problem, [less[k].hypothesis for k in compliant]), strict=True):
            less[k] = whole
    return less


def _on_the_other_side(h: Hypothesis, name: str) -> bool:
    """Whether an added friction that every machine has was found on both sides of backlash or compliance.

    The torque shows the sum of both sides. The encoders show how it is shared, since the output friction winds up the
    shaft and holds the output within the gap.
    """
    alike = [i.effect for i in h.added.values() if name in h.added and i.effect == h.added[name].effect]
    return len(alike) > 1 and catalogue()[alike[0]].every_machine


def without_effect(h: Hypothesis, name: str) -> Hypothesis:
    """Hypothesis without one effect, at a start where the others compensate for it."""
    instance = h.instance(name)
    rest = h.without(name)
    if instance.effect != TORQUE_FACTOR:
        return rest
    return rest.with_torques_times(1.0 / instance.parameters["scale"])


def added_and_removed(rounds: Iterable[Round]) -> frozenset[str]:
    """Effects that were removed in the round that added them."""
    return frozenset(turn.effect_of(name) for turn in rounds for name in turn.removed if name in turn.added)
