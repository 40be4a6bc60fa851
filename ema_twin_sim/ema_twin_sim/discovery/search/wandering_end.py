"""The end of a search, judged once more with friction that wanders as part of the noise.

Beside a gearbox, or where several effects are missing, wandering shows only once all of them were found: the same
effects, fitted beside it, may leave nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...criteria import BESIDE_IMPACTS, CORRELATION
from ...identification.equation import FAR, EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.wandering import wandering
from ..criteria.explained import explained
from .search import add_effects, depends_on_more, settle, significant, torque_left
from .trace import Search


def wandering_after_all(
    problem: EquationErrorProblem, found: Search, without: frozenset[str], start: Fit, progress: Callable[[str], None]
) -> Search | None:
    """The search, its end beside friction that wanders, where nothing else is left then; None where more is."""
    wander = None if found.weighting.wander is not None else wandering(problem, found.fit)
    if wander is None:
        return None
    progress(f"friction seems to wander by {wander.share:.1%}: judging the end beside that")
    plain = problem.weighting
    problem.weighting = replace(plain.begun_anew(BESIDE_IMPACTS if found.fit.parted else FAR), wander=wander)
    after, rounds = add_effects(problem, settle(problem, fit(problem, found.fit.hypothesis)), without, progress)
    beside = significant(
        problem, replace(found, fit=after, rounds=(*found.rounds, *rounds), weighting=problem.weighting)
    )
    allowed = torque_left(problem, beside.fit) + CORRELATION * wander.complexity_penalty / problem.size
    if explained(problem, beside.fit, start):
        weighting = problem.weighting
        problem.weighting = plain
        if not depends_on_more(problem, beside.fit.hypothesis, allowed):
            problem.weighting = weighting
            return beside
    problem.weighting = plain
    return None
