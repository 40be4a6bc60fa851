"""Put back constants that the recordings did not move to their values in the model file.

A search frees all constants, and each ends somewhere within its standard error. Such a move says nothing about the
machine, but with tooth contact it shifts every impact in time. So constants are put back and the rest is fitted again:
first all constants, then those that are not known to have moved. The closed loop decides whether the result follows the
recordings as well; of a rigid drivetrain the torque tells as much, without a simulation.
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
    """The search, with constants that did not clearly move back at their file values."""
    best = found.fit
    if best.hypothesis.base.is_open or not found.taken or {*loop.inputs} != {"setpoint"}:
        return found
    put_back = _put_back(best)
    if not best.parted:
        if put_back is None or put_back.misfit > (1.0 + NEGLIGIBLE) * best.misfit:
            return found
        return found.with_numbers(put_back)
    simpler = [_as_filed(best), *([] if put_back is None else [put_back])]
    fitted, *errors = loop.errors(f.hypothesis for f in (best, *simpler))
    least = min([fitted, *errors])
    for rest, error in zip(simpler, errors, strict=True):
        if math.isfinite(error) and error <= (1.0 + NEGLIGIBLE) * least:
            return found.with_numbers(rest)
    return found


def beside_constants_as_filed(found: Search) -> Search:
    """The search, with the effects' numbers as they are and all constants held at their file values.

    An unknown cause may pull the constants away from where they follow the recordings, without affecting the effects.
    """
    h = found.fit.hypothesis
    return found.with_numbers(fit(found.problem, h.holding(h.nominal()), 0))


def freed(found: Search, of: Search) -> Search:
    """The search with its current numbers, freed in the same way as those of another with the same effects."""
    return found.with_numbers(fit(found.problem, of.fit.hypothesis.at(found.fit.hypothesis.values), 0))


def _as_filed(best: Fit) -> Fit:
    """Fit with all constants and the teeth at their file values.

    In a two-inertia model the errors of the constants lie along a ridge of shares that trade off against each other.
    Each constant may seem to have moved by many of its standard errors.
    """
    h = best.hypothesis
    values = {path: value for path, value in h.nominal().items() if path != LAG}
    with_teeth = h.holding(h.teeth_of_the_file())  # held for good: they may be stiffer than a search allows
    return _fitted_beside(best.problem, with_teeth, values)


def _put_back(best: Fit) -> Fit | None:
    """Fit with the constants that are not known to have moved at their file values; None if all have moved."""
    sure = standard_errors(best.problem, best)
    now, nominal = best.hypothesis.by_path, best.hypothesis.nominal()
    unmoved = {p: value for p, value in nominal.items() if abs(now[p] - value) < LIKELY * sure.get(p, 0.0)}
    return _fitted_beside(best.problem, best.hypothesis, unmoved) if unmoved else None


def _fitted_beside(problem: EquationErrorProblem, h: Hypothesis, values: Mapping[str, float]) -> Fit:
    """Fit with some numbers (by path) held at values; at the end they are free again, at those values."""
    rest = fit(problem, h.holding(values))
    return fit(problem, h.at(rest.hypothesis.values), 0)
