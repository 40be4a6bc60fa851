"""Constants that the recordings do not move stay where the model's file has them.

A search frees all constants, and each ends somewhere within its standard error. To have moved that far says nothing
of the machine, yet where teeth meet it puts every impact at another instant. So constants are put back and the rest
fitted again, all of them first, then those that are not known to have moved, and the closed loop tells whether it
follows the recordings as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..criteria import LIKELY, NEGLIGIBLE
from ..identification.equation import EquationErrorProblem
from ..identification.estimates import standard_errors
from ..identification.fit import Fit, fit
from ..identification.hypothesis import LAG, Hypothesis
from .search.trace import Search
from .split import ClosedLoop


def with_unmoved_constants(loop: ClosedLoop, found: Search) -> Search:
    """The search, at its end the constants that did not surely move back at their file's values."""
    best = found.fit
    if best.hypothesis.base.is_open or not found.taken or {*loop.inputs} != {"setpoint"}:
        return found
    simpler = [rest for rest in (_as_filed(best), _put_back(best)) if rest is not None]
    fitted, *errors = loop.errors(f.hypothesis for f in (best, *simpler))
    least = min([fitted, *errors])
    for rest, error in zip(simpler, errors, strict=True):
        if math.isfinite(error) and error <= (1.0 + NEGLIGIBLE) * least:
            return found.with_numbers(rest)
    return found


def beside_constants_as_filed(found: Search) -> Search:
    """The search, at its end the effects' numbers as they are and all constants held at their file's values.

    What is unknown may lead the constants away from where they follow the recordings, and not the effects beside them.
    """
    h = found.fit.hypothesis
    values = {free.path: free.prior[0] for free in h.free if free.prior is not None}
    return found.with_numbers(fit(found.problem, h.holding(values), 0))


def freed(found: Search, of: Search) -> Search:
    """The search with its numbers where they are, as free as those of another with the same effects."""
    return found.with_numbers(fit(found.problem, of.fit.hypothesis.at(found.fit.hypothesis.values), 0))


def _as_filed(best: Fit) -> Fit | None:
    """The fit with all constants and the teeth at their file's values; None where no sides part.

    Where they do, the constants' errors lie along a ridge of shares that trade with each other: each of them may seem
    to have moved by many of its standard errors.
    """
    if not best.parted:
        return None
    h = best.hypothesis
    values = {free.path: free.prior[0] for free in h.free if free.prior is not None and free.path != LAG}
    with_teeth = h.holding(h.teeth_of_the_file())  # for good: they may be stiffer than a search goes
    return _fitted_beside(best.problem, with_teeth, values)


def _put_back(best: Fit) -> Fit | None:
    """The fit with the constants that are not known to have moved at their file's values; None where all have."""
    sure = standard_errors(best.problem, best)
    values = best.hypothesis.by_path
    unmoved = {
        free.path: free.prior[0]
        for free in best.hypothesis.free
        if free.prior is not None and abs(values[free.path] - free.prior[0]) < LIKELY * sure.get(free.path, 0.0)
    }
    return _fitted_beside(best.problem, best.hypothesis, unmoved) if unmoved else None


def _fitted_beside(problem: EquationErrorProblem, h: Hypothesis, values: Mapping[str, float]) -> Fit:
    """The fit with some numbers, by path, held at values; in the end they are free again, where they are."""
    rest = fit(problem, h.holding(values))
    return fit(problem, h.at(rest.hypothesis.values), 0)
