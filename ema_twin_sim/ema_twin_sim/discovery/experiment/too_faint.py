"""What the recordings would not show: effects of a usual size that may be there all the same.

An explanation of slow recordings says nothing of drag; one in which the output hardly turned, nothing of its encoder's
centre. Where nothing else is in doubt, such effects are, and a recording is planned that would show most of them.
"""

from __future__ import annotations

from dataclasses import replace

from ...criteria import COST_EFFECT, COST_PARAMETER, SIGNIFICANT
from ...effects import catalogue
from ...identification.candidates import Candidate, candidates
from ...identification.equation import EquationErrorProblem
from ...identification.fit import Fit, fit
from ...identification.hypothesis import COMPLIANT_EFFECTS
from ...identification.screening import would_show
from ..criteria.worth import penalised_gain
from ..search.trace import Search
from .doubts import NOTHING, Doubt, Rival


def too_faint(problem: EquationErrorProblem, found: Search, without: frozenset[str]) -> Doubt | None:
    """The doubt about effects that would not show by as much as it takes to name them; None where all would."""
    best = found.fit
    if best.hypothesis.generic_bases:
        return None
    usual: dict[str, Candidate] = {}
    for c in candidates(best.hypothesis, without | set(COMPLIANT_EFFECTS) | best.hypothesis.held):
        if c.options == catalogue()[c.effect].default_options():
            usual.setdefault(c.effect, c)
    shown = would_show(problem, best, [*usual.values()])
    hidden = [id for id, deviations in zip(usual, shown, strict=True) if deviations < SIGNIFICANT]
    if not hidden:
        return None
    rivals = [Rival(id, _beside(problem, best, id)) for id in hidden]
    behind = [_price(rival.name) - penalised_gain(problem, best, rival.fit) for rival in rivals]
    reason = f"these recordings would not show {_listed(hidden)} of a usual size"
    return Doubt((Rival(NOTHING, best), *rivals), (0.0, *behind), reason)


def _beside(problem: EquationErrorProblem, best: Fit, id: str) -> Fit:
    """An effect of its typical size beside an explanation, whose numbers give way to it."""
    base = best.hypothesis.base.with_effect(id)
    return fit(problem, replace(best.hypothesis, base=base), 4, known=best)


def _price(id: str) -> float:
    """What an effect costs that a model has as it is."""
    return COST_EFFECT + COST_PARAMETER * len(catalogue()[id].parameters)


def _listed(ids: list[str]) -> str:
    return ids[0] if len(ids) == 1 else f"{', '.join(ids[:-1])} or {ids[-1]}"
