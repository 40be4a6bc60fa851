"""Standard errors of the end of a search, beside the curves that stand for an unknown cause."""

from __future__ import annotations

from ..identification.equation import EquationErrorProblem
from ..identification.estimates import standard_errors
from ..identification.fit import Fit, fit
from .criteria.worth import is_lacked


def errors_beside_curves(problem: EquationErrorProblem, f: Fit) -> dict[str, float]:
    """Standard errors of the free parameters, by path.

    Curves of friction over a position, a speed or the time of all recordings can do what dry friction does. An effect
    that every machine has stands beside them all the same, with the size that it had before the curves came: its errors
    are those without them, among what they explain.
    """
    sure, h = standard_errors(problem, f), f.hypothesis
    lacked = [name for name, instance in h.added.items() if is_lacked(h, instance.effect)]
    if not (h.generic_bases and lacked):
        return sure
    alone = standard_errors(problem, fit(problem, h.without_generic_bases(), 0))
    return sure | {path: std for path, std in alone.items() if path.startswith(tuple(f"effects.{n}." for n in lacked))}
