"""Search order: effects that were found one after another, and others that explain more together.

A stepwise search adds the effect that fits best alone, which keeps out what fits best in combination: a sum of two
friction curves over speed is close to many sums of two others. So other effects are added first.
"""

from __future__ import annotations

from collections.abc import Callable

from ...effects import catalogue
from ...identification.fit import fit
from ..criteria.plausible import strained
from ..criteria.worth import penalised_gain
from .adding import add_effects, entrants, with_one_more
from .laws import under_best_laws
from .removing import significant
from .rivals import swapped
from .trace import Search

MORE = 2  # effects that may join the first ones


def in_another_order(found: Search, without: frozenset[str], progress: Callable[[str], None]) -> Search:
    """The search with other effects in place of those over speed, if these explain more together.

    Tried if at least two effects depend on speed, or if the friction constants are strained. Each candidate is added
    first once.
    """
    best, problem = found.fit, found.problem
    alike = [n for n, held in best.hypothesis.added.items() if _by_speed(held.effect)]
    if best.parted or (len(alike) < 2 and "speed" not in strained(best)):
        return found
    progress("trying other friction curves together with the other effects")
    start = fit(problem, best.hypothesis.without(*alike))
    others = without | {id for id in catalogue() if not _by_speed(id)}
    for effect in sorted(catalogue().keys() - others):
        for h in entrants(problem, start, frozenset(catalogue().keys() - {effect}))[:1]:
            other, _ = add_effects(with_one_more(start, h), others, most=MORE)
            other = fit(problem, other.hypothesis)  # misfits compare only under the same weighting
            if penalised_gain(best, other) > 1.0:
                best = other
    if best is not found.fit:
        better = significant(under_best_laws(swapped(found, best)))
        if penalised_gain(found.fit, fit(problem, better.fit.hypothesis)) > 0.0:
            return better
    return found


def _by_speed(effect: str) -> bool:
    return catalogue()[effect].depends_on == "speed"
