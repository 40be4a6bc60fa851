"""The end of a search, judged once more with wandering friction as part of the noise.

With a gearbox, or if several effects are missing, wandering shows only after all of them were found: the same effects,
fitted with wandering, may leave nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...criteria import BESIDE_IMPACTS, DEPENDS
from ...effects import catalogue
from ...identification.fit import Fit, fit
from ...identification.wander import Wander
from ...identification.wandering import wandering
from ...identification.weighting import FAR
from ..criteria.explained import explained
from ..criteria.worth import penalised_gain
from .adding import add_effects, prune, settle
from .removing import less, significant
from .search import depends_on_more, explains_torque_with, torque_left
from .trace import WANDERS, WANDERS_OVER_TIME, Search


def wandering_after_all(
    found: Search, without: frozenset[str], start: Fit, progress: Callable[[str], None]
) -> Search | None:
    """The search with wandering friction at its end, if nothing else is left then; None otherwise."""
    plain = found.problem
    wander = _wander(found)
    if wander is None:
        return None
    progress(f"friction seems to vary slowly by {wander.share:.1%}: judging the result with that as part of the noise")
    beside = significant(found.further(*add_effects(with_wander(found.fit, wander), without, progress)))
    allowed = torque_left(beside.fit) + plain.correlation * wander.complexity_penalty / plain.size
    if explained(beside.problem, beside.fit, start) and not depends_on_more(plain, beside.fit.hypothesis, allowed):
        return beside
    return None


def less_what_wandering_explains(found: Search, progress: Callable[[str], None]) -> Search:
    """The search with wandering friction, without what is needless then; unchanged if nothing is.

    Only with backlash or compliance, where the search could not test this before both were found: what wandering adds
    over a few reversals looks like some friction curve, and like a small load. With wandering, which has absorbed some
    of it, an effect may be small; if it still gains clearly, nothing else explains it.
    """
    wander = _wander(found) if found.fit.parted else None
    if wander is None:
        return found
    progress(f"friction seems to vary slowly by {wander.share:.1%}: checking which effects that explains as well")
    beside = with_wander(found.fit, wander)
    after = prune(beside)
    return found if after is beside else significant(found.ended(after, WANDERS))


def without_warming_that_wandering_explains(found: Search) -> Search:
    """With open constants: the search without effects over time that wandering friction explains as well.

    Wandering is not part of the noise there, since free friction constants do much of the same. But over one recording,
    friction that falls and rises again looks like friction that warms up.
    """
    over_time = [n for n, i in found.fit.hypothesis.added.items() if catalogue()[i.effect].depends_on == "time"]
    wander = _wander(found) if over_time else None
    if wander is None:
        return found
    beside = with_wander(found.fit, wander)
    gains = {
        name: penalised_gain(fit(beside.problem, beside.hypothesis.without(name)), beside)
        for name in over_time
        if name in beside.hypothesis.added
    }
    least = min(gains, key=gains.__getitem__, default=None)
    if least is None or gains[least] > DEPENDS:
        return found
    return without_warming_that_wandering_explains(significant(less(found, [least], WANDERS_OVER_TIME)))


def _wander(found: Search) -> Wander | None:
    """How friction wanders, by the residual at the end; None if it does not show or is already part of the noise."""
    return None if found.problem.weighting.wander is not None else wandering(found.problem, found.fit)


def beside_wandering(found: Search) -> Fit | None:
    """The end of a search with wandering friction as part of the noise; None unless that explains the torque."""
    wander = _wander(found)
    beside = None if wander is None else with_wander(found.fit, wander)
    return beside if wander and beside and explains_torque_with(wander, found.problem, beside) else None


def with_wander(f: Fit, wander: Wander) -> Fit:
    """The same effects, fitted with wandering friction."""
    begun = f.problem.weighting.begun_anew(BESIDE_IMPACTS if f.parted else FAR)
    return settle(fit(f.problem.under(replace(begun, wander=wander)), f.hypothesis))
