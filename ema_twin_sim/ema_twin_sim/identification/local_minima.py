"""Local minima: what rings and bounces has many, side by side, and a fit from afar ends in the wrong one."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from ..criteria import BESIDE_IMPACTS, FAR_OFF_ROW, NEGLIGIBLE
from .equation import EquationErrorProblem
from .fit import Fit, fit
from .hypothesis import Hypothesis

FINALISTS = 2
STIFFER = (0.8, 0.9, 1.0, 1.1, 1.25)  # times a stiffness, and times a damping, that a hop leads to
DAMPED = (0.25, 0.5, 1.0, 2.0, 4.0)
HOPS = 3  # at most


def starting(h: Hypothesis, factors: Mapping[str, float]) -> Hypothesis:
    """A hypothesis some of whose numbers, by path, are multiplied, unless they are held."""
    moving = {free.path for free in h.free if free.lower < free.upper}
    return h.put(
        {path: value * factors[path] for path, value in h.by_path.items() if path in factors and path in moving}
    )


def ranked(problem: EquationErrorProblem, family: Sequence[Hypothesis]) -> list[tuple[float, Hypothesis]]:
    """The hypotheses with their misfits as they are, the best first; what is far off counts little."""
    problem.weighting = problem.weighting.from_outliers(FAR_OFF_ROW)
    costs = [problem.misfit(problem.unexplained(rows)) for rows in problem.rows_of(family)]
    return [(costs[int(k)], family[int(k)]) for k in np.argsort(costs)]


def best_of(problem: EquationErrorProblem, family: Sequence[tuple[float, Hypothesis]]) -> Fit:
    """The best fit of a ranked family: from its best few, then from beside there."""
    problem.weighting = problem.weighting.from_outliers(FAR_OFF_ROW)
    finalists = [fit(problem, h, 8).hypothesis for _, h in family[:FINALISTS]]
    problem.weighting = problem.weighting.from_outliers(BESIDE_IMPACTS)
    return hopped(problem, min((fit(problem, h, 8) for h in finalists), key=cost), family[0][1].added)


def hopped(problem: EquationErrorProblem, best: Fit, names: Collection[str]) -> Fit:
    """The best of a fit and those that start beside it, where the springs of these effects are others.

    One start has all constants as the model file has them: a valley that was entered without the last effect, to make
    up for which they gave way, is not one that a fit finds out of.
    """
    for _ in range(HOPS):
        beside = [starting(best.hypothesis, hop) for hop in _hops(best.hypothesis, names)]
        costs = [problem.misfit(problem.unexplained(rows)) for rows in problem.rows_of(beside)]
        starts = [_as_in_the_model(best.hypothesis), *(beside[int(k)] for k in np.argsort(costs)[:1])]
        better = min((fit(problem, h, 8) for h in starts), key=cost)
        much = cost(better) < (1.0 - NEGLIGIBLE) * cost(best)
        best = min(best, better, key=cost)
        if not much:
            break
    return best


def cost(f: Fit) -> float:
    """What a fit makes small."""
    return f.misfit + f.variance_inflation * f.prior_cost


def _hops(h: Hypothesis, names: Collection[str]) -> Iterator[dict[str, float]]:
    """Factors, by path, that lead beside a hypothesis: stiffness and damping of an effect, or of the teeth."""
    owners = [f"effects.{name}" for name in names]
    if any(h.added[name].effect == "backlash" for name in names):
        owners.append("contact")
    paths = {free.path for free in h.free}
    for owner in owners:
        if f"{owner}.stiffness" in paths:
            damped = DAMPED if f"{owner}.damping" in paths else (1.0,)
            for stiffness, damping in itertools.product(STIFFER, damped):
                yield {f"{owner}.stiffness": stiffness, f"{owner}.damping": damping}


def _as_in_the_model(h: Hypothesis) -> Hypothesis:
    """A hypothesis with all constants that have a tolerance at their nominal values."""
    return h.put({free.path: free.prior[0] for free in h.free if free.prior is not None})
