"""Laws: the form of an effect's equation that explains most beside the other effects.

A round that adds an effect compares the forms beside what is still missing then, which may favour the wrong one; the
wrong form leaves a remainder, for which a search would take further effects.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...criteria import DEPENDS
from ...effects import Effect, catalogue
from ...identification.candidates import Candidate, starts
from ...identification.fit import Fit, fit, fits
from ...identification.hypothesis import Hypothesis
from ..criteria.worth import penalised_gain
from .trace import Search

ITERATIONS = 4  # of a fit that only shows how good a law is


def with_best_laws(f: Fit) -> Fit:
    """A fit with each added effect under the law of its equation that explains most; the same one if it has these.

    Other laws are first fitted with the slopes of the other effects as they are. That makes a law look worse than it
    is, so the best of them is fitted in full unless it is clearly worse.
    """
    for name, held in f.hypothesis.added.items():
        effect = catalogue()[held.effect]
        for _ in _laws(effect):  # no more often than there are laws
            better = _under_a_better_law(f, name, effect)
            if better is None:
                break
            f = better
    return f


def _under_a_better_law(f: Fit, name: str, effect: Effect) -> Fit | None:
    """A fit with one of its effects under another law that explains more; None if none does."""
    rivals = fits(f.problem, _under_other_laws(f, name, effect), ITERATIONS, known=f)
    best = max(rivals, key=lambda rival: penalised_gain(f, rival), default=None)
    if best is None or penalised_gain(f, best) <= -DEPENDS:
        return None
    best = fit(f.problem, best.hypothesis)
    return best if penalised_gain(f, best) > 0.0 else None


def _under_other_laws(f: Fit, name: str, effect: Effect) -> list[Hypothesis]:
    """The hypothesis of a fit with one of its effects under each law that it has not, from the same numbers.

    Laws that the recordings do not show are left out.
    """
    instance = f.hypothesis.instance(name)
    bare = f.hypothesis.without(name)
    others = [{**instance.options, effect.law: law} for law in _laws(effect) if law != instance.options[effect.law]]
    return [
        bare.with_effect(effect.id, options, instance.parameters)
        for options in others
        if any(starts(Candidate(effect.id, options), f.problem.reached, bare.base.units))
    ]


def _laws(effect: Effect) -> Sequence[str]:
    """The laws of an effect's equation; none if it has one form."""
    return effect.options[effect.law] if effect.law else ()


def under_best_laws(found: Search) -> Search:
    """The search with each added effect at its end under the law that explains most."""
    best = with_best_laws(found.fit)
    return found if best is found.fit else found.refitted(best)
