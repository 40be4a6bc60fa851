"""The end of a search, judged once more with wandering friction as part of the noise.

With a gearbox, or if several effects are missing, wandering shows only after all of them were found: the same effects,
fitted with wandering, may leave nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...criteria import BESIDE_IMPACTS, DEPENDS, TOLERANCE
from ...effects import catalogue
from ...identification.fit import Fit, fit
from ...identification.wander import Wander
from ...identification.wandering import wandering
from ...identification.weighting import FAR
from ..criteria.explained import explained
from ..criteria.worth import ENCODER_ONLY, penalised_gain
from .adding import add_effects, prune, settle, without_effect
from .removing import less, significant
from .search import depends_on_more, explains_torque_with, torque_cost, torque_left
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
    beside = significant(found.further(*add_effects(_beside(found.fit, wander), without, progress)))
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
    beside = _beside(found.fit, wander)
    after = prune(beside)
    return found if after is beside else significant(found.ended(after, WANDERS))


def less_what_wanders_as_well(found: Search, progress: Callable[[str], None]) -> Search:
    """The search of one recording, without effects that friction which wanders a little explains as well.

    In one recording everything has happened once: what depends on the place, the speed or the temperature may as well
    depend on the time. With several, an effect must explain each of them with the same numbers, which wandering never
    does.
    """
    if len(found.problem.observations) > 1:
        return found
    while (instead := _wandering_instead(found)) is not None:
        name, wander = instead
        progress(f"friction seems to vary slowly by {wander.share:.1%}: that explains as much as {name}")
        found = significant(found.ended(prune(_beside(less(found, [name], WANDERS).fit, wander)), WANDERS))
    return found


def _wandering_instead(found: Search) -> tuple[str, Wander] | None:
    """The added effect that wandering friction replaces best, at hardly any more cost, and how it wanders then."""
    f = found.fit
    if f.problem.weighting.wander is not None:
        return None
    likely: list[tuple[float, str, Wander]] = []
    for name, held in f.hypothesis.added.items():
        if held.effect in ENCODER_ONLY:
            continue
        bare = fit(f.problem, without_effect(f.hypothesis, name))
        wander = wandering(f.problem, bare)
        if wander is not None and wander.share <= TOLERANCE:
            likely.append((torque_cost(_beside(bare, wander)) + wander.complexity_penalty, name, wander))
    least = min(likely, key=lambda one: one[0], default=None)
    return None if least is None or least[0] > torque_cost(f) + DEPENDS else least[1:]


def without_warming_that_wandering_explains(found: Search) -> Search:
    """With open constants: the search without effects over time that wandering friction explains as well.

    Wandering is not part of the noise there, since free friction constants do much of the same. But over one recording,
    friction that falls and rises again looks like friction that warms up.
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
    """How friction wanders, by the residual at the end; None if it does not show or is already part of the noise."""
    return None if found.problem.weighting.wander is not None else wandering(found.problem, found.fit)


def beside_wandering(found: Search) -> Fit | None:
    """The end of a search with wandering friction as part of the noise; None unless that explains the torque."""
    wander = _wander(found)
    beside = None if wander is None else _beside(found.fit, wander)
    return beside if wander and beside and explains_torque_with(wander, found.problem, beside) else None


def _beside(f: Fit, wander: Wander) -> Fit:
    """The same effects, fitted with wandering friction."""
    begun = f.problem.weighting.begun_anew(BESIDE_IMPACTS if f.parted else FAR)
    return settle(fit(f.problem.under(replace(begun, wander=wander)), f.hypothesis))
