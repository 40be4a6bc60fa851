"""The end of a search, judged once more with friction that wanders as part of the noise.

Beside a gearbox, or where several effects are missing, wandering shows only once all of them were found: the same
effects, fitted beside it, may leave nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...criteria import BESIDE_IMPACTS, CORRELATION
from ...identification.fit import Fit, fit
from ...identification.wandering import wandering
from ...identification.weighting import FAR
from ..criteria.explained import explained
from .search import add_effects, depends_on_more, settle, significant, torque_left
from .trace import Search


def wandering_after_all(
    found: Search, without: frozenset[str], start: Fit, progress: Callable[[str], None]
) -> Search | None:
    """The search, its end beside friction that wanders, where nothing else is left then; None where more is."""
    plain = found.problem
    wander = None if plain.weighting.wander is not None else wandering(plain, found.fit)
    if wander is None:
        return None
    progress(f"friction seems to wander by {wander.share:.1%}: judging the end beside that")
    begun = plain.weighting.begun_anew(BESIDE_IMPACTS if found.fit.parted else FAR)
    anew = fit(plain.under(replace(begun, wander=wander)), found.fit.hypothesis)
    beside = significant(found.further(*add_effects(settle(anew), without, progress)))
    allowed = torque_left(beside.fit) + CORRELATION * wander.complexity_penalty / plain.size
    if explained(beside.problem, beside.fit, start) and not depends_on_more(plain, beside.fit.hypothesis, allowed):
        return beside
    return None
