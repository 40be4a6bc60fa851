"""The order of a search: effects that were found one after the other, and others that explain more together.

One step at a time, what fits best alone comes in, and keeps out what fits best in company: a sum of two friction curves
over the speed comes near many a sum of two others. So others come in first, or what came in first is left out, the rest
is sought without it, and then it may come back.
"""

from __future__ import annotations

from collections.abc import Callable

from ...criteria import USUAL_EFFECTS
from ...effects import catalogue
from ...identification.fit import Fit, fit
from ...identification.hypothesis import Hypothesis
from ..criteria.plausible import strained
from ..criteria.worth import ENCODER_ONLY, penalised_gain
from .adding import add_effects, entrants, with_one_more
from .removing import significant
from .rivals import swapped
from .search import search
from .trace import Search

MORE = 2  # effects that may join those that came in first
THOUGHTS = 2  # of the effects that were found first, those that are doubted where something is left


def in_another_order(found: Search, without: frozenset[str], progress: Callable[[str], None]) -> Search:
    """The search with other effects in the place of those that show over the speed, where these explain more together.

    Asked where several do, or where the constants of friction were drawn far off: each of them comes in first once.
    """
    best, problem = found.fit, found.problem
    alike = [n for n, held in best.hypothesis.added.items() if _by_speed(held.effect)]
    if best.parted or (len(alike) < 2 and "speed" not in strained(best)):
        return found
    progress("trying other friction curves in company")
    bare = best.hypothesis
    for name in alike:
        bare = bare.without(name)
    start = fit(problem, bare)
    others = without | {id for id in catalogue() if not _by_speed(id)}
    for effect in sorted(catalogue().keys() - others):
        for h in entrants(problem, start, frozenset(catalogue().keys() - {effect}))[:1]:
            other, _ = add_effects(with_one_more(start, h), others, most=MORE)
            other = fit(problem, other.hypothesis)  # misfits compare under one weighting only
            if penalised_gain(best, other) > 1.0:
                best = other
    if best is not found.fit:
        better = significant(swapped(found, best))
        if penalised_gain(found.fit, fit(problem, better.fit.hypothesis)) > 0.0:
            return better
    return found


def search_without_first(
    null: Hypothesis,
    excluded: frozenset[str],
    found: Search,
    content: Callable[[Fit], bool],
    progress: Callable[[str], None],
) -> tuple[Search, bool]:
    """A search with a ``content`` end, begun without one of the effects that came first; else the one given.

    With it, whether its end is ``content``.
    """
    firsts = [turn.effect_of(name) for turn in found.taken for name in turn.added if name in found.fit.hypothesis.added]
    for effect in list(dict.fromkeys(firsts))[:THOUGHTS]:
        other = search(found.problem, null, excluded | {effect}, progress, most=USUAL_EFFECTS, may_wander=False)
        if other.fit.parted:
            continue
        other = significant(other.further(*add_effects(other.fit, excluded | ENCODER_ONLY, progress, most=MORE)))
        if content(other.fit):
            return other, True
    return found, False


def _by_speed(effect: str) -> bool:
    return catalogue()[effect].depends_on == "speed"
