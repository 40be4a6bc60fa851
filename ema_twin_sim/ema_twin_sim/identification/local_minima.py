"""Local minima: models that ring or bounce have many, and a fit from a distant start ends in the wrong one."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from ..criteria import BESIDE_IMPACTS, FAR_OFF_ROW, NEGLIGIBLE
from ..model.roles import PLAY, SPRING
from .comparable import cheapest, costs_no_more
from .equation import EquationErrorProblem
from .fit import Fit, fits
from .hypothesis import DRY_SCALE, INERTIAS, Hypothesis, dry_friction

FINALISTS = 2
STIFFER = (0.8, 0.9, 1.0, 1.1, 1.25)  # factors on a stiffness that a hop tries
DAMPED = (0.25, 0.5, 1.0, 2.0, 4.0)
HEAVIER = (0.6, 0.8, 1.25, 1.6)  # factors on everything behind backlash or compliance
HOPS = 3  # at most


def starting(h: Hypothesis, factors: Mapping[str, float]) -> Hypothesis:
    """A hypothesis with some parameters (by path) multiplied, unless they are held."""
    moving = {free.path for free in h.free if free.lower < free.upper}
    return h.put(
        {path: value * factors[path] for path, value in h.by_path.items() if path in factors and path in moving}
    )


def ranked(problem: EquationErrorProblem, family: Sequence[Hypothesis]) -> list[tuple[float, Hypothesis]]:
    """Hypotheses with their misfits before fitting, best first; outliers have little weight."""
    problem = problem.under(problem.weighting.from_outliers(FAR_OFF_ROW))
    costs = [problem.misfit(problem.unexplained(rows)) for rows in problem.rows_of(family)]
    return [(costs[int(k)], family[int(k)]) for k in np.argsort(costs)]


def best_of(problem: EquationErrorProblem, family: Sequence[tuple[float, Hypothesis]]) -> Fit:
    """Best fit of a ranked family: fit its best few, then try nearby local minima."""
    from_afar = problem.under(problem.weighting.from_outliers(FAR_OFF_ROW))
    finalists = [f.hypothesis for f in fits(from_afar, [h for _, h in family[:FINALISTS]])]
    near = problem.under(problem.weighting.from_outliers(BESIDE_IMPACTS))
    return hopped(cheapest(fits(near, finalists)), family[0][1].added)


def hopped(best: Fit, names: Collection[str]) -> Fit:
    """The best of a fit and of fits restarted nearby, with the springs of these effects changed.

    One restart has all constants at their file values: they may have moved to compensate for a missing effect, and a
    fit does not find its way out of that local minimum.
    """
    problem = best.problem
    for _ in range(HOPS):
        hops = (*_hops(best.hypothesis, names), *output_weights(best.hypothesis))
        beside = [starting(best.hypothesis, hop) for hop in hops]
        costs = [problem.misfit(problem.unexplained(rows)) for rows in problem.rows_of(beside)]
        as_filed = best.hypothesis.put(best.hypothesis.nominal())
        starts = [as_filed, *(beside[int(k)] for k in np.argsort(costs)[:1])]
        better = cheapest(fits(problem, starts))
        much = costs_no_more(better, best, 1.0 - NEGLIGIBLE)
        best = cheapest((best, better))
        if not much:
            break
    return best


def _hops(h: Hypothesis, names: Collection[str]) -> Iterator[dict[str, float]]:
    """Factors, by path, for nearby starts: stiffness and damping of an effect, or of the teeth."""
    owners = [f"effects.{name}" for name in names]
    if any(h.added[name].effect == PLAY for name in names):
        owners.append("contact")
    paths = {free.path for free in h.free}
    for owner in owners:
        if f"{owner}.stiffness" in paths:
            damped = DAMPED if f"{owner}.damping" in paths else (1.0,)
            for stiffness, damping in itertools.product(STIFFER, damped):
                yield {f"{owner}.stiffness": stiffness, f"{owner}.damping": damping}


def output_weights(h: Hypothesis) -> Iterator[dict[str, float]]:
    """Factors, by path, that make all behind backlash or compliance heavier, or lighter; the motor side inversely.

    The encoder difference determines the ratios of inertia, friction and contact behind it, not their absolute size.
    The torque determines that, but the encoder rows are so steep that a fit does not get there. Only if these are open;
    otherwise the file gives them.
    """
    free = {one.path: one for one in h.free}
    outer = free.get("scale.output_inertia")
    if outer is None or outer.prior is not None:
        return
    model = h.model()
    motor, output = sum(model.value(path) for path in INERTIAS[:-1]), model.value(INERTIAS[-1])
    dry = dry_friction(model.effects[name] for name in h.base.active)
    springs = [f"effects.{name}" for name, one in h.added.items() if one.effect == SPRING]
    behind = ["scale.output_inertia", "scale.output_coulomb"]
    behind += [f"{owner}.{number}" for owner in ("contact", *springs) for number in ("stiffness", "damping")]
    for factor in HEAVIER:
        lighter = {
            "scale.inertia": 1.0 + (1.0 - factor) * output / max(motor, 1e-30),
            DRY_SCALE: 1.0 + (1.0 - factor) * dry["output"] / max(dry["motor"], 1e-30),
        }
        if min(lighter.values()) > 0.0:
            yield {**dict.fromkeys(behind, factor), **lighter}
