"""The end of a search, judged once more with friction that wanders as part of the noise.

Beside a gearbox, or where several effects are missing, wandering shows only once all of them were found: the same
effects, fitted beside it, may leave nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...criteria import BESIDE_IMPACTS, CORRELATION, DEPENDS
from ...effects import catalogue
from ...identification.fit import Fit, fit
from ...identification.wander import Wander
from ...identification.wandering import wandering
from ...identification.weighting import FAR
from ..criteria.explained import explained
from ..criteria.worth import penalised_gain
from .adding import add_effects, prune, settle
from .removing import less, significant
from .search import depends_on_more, torque_left
from .trace import WANDERS, WANDERS_OVER_TIME, Search


def wandering_after_all(
    found: Search, without: frozenset[str], start: Fit, progress: Callable[[str], None]
) -> Search | None:
    """The search, its end beside friction that wanders, where nothing else is left then; None where more is."""
    plain = found.problem
    wander = _wander(found)
    if wander is None:
        return None
    progress(f"friction seems to wander by {wander.share:.1%}: judging the end beside that")
    beside = significant(found.further(*add_effects(_beside(found.fit, wander), without, progress)))
    allowed = torque_left(beside.fit) + CORRELATION * wander.complexity_penalty / plain.size
    if explained(beside.problem, beside.fit, start) and not depends_on_more(plain, beside.fit.hypothesis, allowed):
        return beside
    return None


def less_what_wandering_explains(found: Search, progress: Callable[[str], None]) -> Search:
    """The search beside friction that wanders and less what is needless then; itself where nothing is.

    Asked beside play or a spring, where the search could not ask before both were found: what the friction's
    wandering adds over a few reversals has the shape of some friction curve, and of a small load. Beside wandering that
    has taken some of it, an effect may be small; one that still gains clearly is explained by nothing else.
    """
    wander = _wander(found) if found.fit.parted else None
    if wander is None:
        return found
    progress(f"friction seems to wander by {wander.share:.1%}: asking what that explains as well")
    beside = _beside(found.fit, wander)
    after = prune(beside)
    return found if after is beside else significant(found.ended(after, WANDERS))


def without_warming_that_wandering_explains(found: Search) -> Search:
    """The search of a machine whose constants are open, less what changes with time where wandering explains that.

    There wandering is no part of the noise, since free constants of friction do much of what it does; but a friction
    that falls and rises again looks like one that warms up, over one recording.
    """
    over_time = [n for n, i in found.fit.hypothesis.added.items() if catalogue()[i.effect].depends_on == "time"]
    wander = _wander(found) if over_time else None
    if wander is None:
        return found
    beside = _beside(found.fit, wander)
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
    """How friction wanders by what an end leaves over; None where nothing shows, or it is part of the noise already."""
    return None if found.problem.weighting.wander is not None else wandering(found.problem, found.fit)


def beside_wandering(found: Search) -> Fit | None:
    """The end of a search, fitted with friction that wanders as part of the noise; None if it does not wander."""
    wander = _wander(found)
    return None if wander is None else _beside(found.fit, wander)


def _beside(f: Fit, wander: Wander) -> Fit:
    """The same effects, fitted beside friction that wanders."""
    begun = f.problem.weighting.begun_anew(BESIDE_IMPACTS if f.parted else FAR)
    return settle(fit(f.problem.under(replace(begun, wander=wander)), f.hypothesis))
