"""Start values of a fit: several, if one start might end in the wrong local minimum."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..criteria import BESIDE_IMPACTS, CLEARLY_MORE, FAR_OFF_ROW
from ..effects import catalogue
from ..effects.catalogue import is_own
from ..identification.candidates import Candidate
from ..identification.compliance import DAMPING, STIFFNESS, WIDTHS, encoder_spread
from ..identification.equation import EquationErrorProblem
from ..identification.excerpt import excerpt
from ..identification.fit import fit
from ..identification.hypothesis import COMPLIANT_EFFECTS
from ..identification.null_hypothesis import null_hypothesis
from ..identification.screening import screen
from ..identification.weighting import FAR, Weighting
from ..model import Model
from ..model.own_units import table_in
from .equation_misfit import EquationMisfit
from .free_parameters import FreeParameters, split, waves
from .solver import Solution, refine, solve

FINALISTS = 4
STEPS = 8  # for a finalist
TRIED = 2  # steps from another start before it is judged

Progress = Callable[[str], None]


def structural_starts(equation: EquationErrorProblem, freedom: FreeParameters, progress: Progress) -> list[np.ndarray]:
    """Start values (k,), best first; for backlash and compliance from a grid, on the seconds with most reversals.

    Both ring and bounce, so a fit from a distant start ends anywhere. The given values are in the grid.
    """
    choices: dict[int, tuple[float, ...]] = {}
    for k, number in enumerate(freedom.numbers):
        part, name, parameter = split(number.path)
        if part == "effects" and freedom.model.effects[name].effect in COMPLIANT_EFFECTS:
            grid = {"stiffness": STIFFNESS, "damping": DAMPING, "width": _widths(equation, freedom.model)}[parameter]
            choices[k] = (float(freedom.start[k]), *grid)
    if not choices or not any(len(o.encoder_rows) for o in equation.observations):
        return [freedom.start]
    part_of = excerpt(equation)
    progress("trying starts of what parts the encoders")
    near = EquationMisfit(part_of, freedom).with_outliers_from(BESIDE_IMPACTS)
    from_afar = near.with_outliers_from(FAR_OFF_ROW)
    starts = []
    for chosen in itertools.product(*choices.values()):
        values = from_afar.freedom.start.copy()
        values[list(choices)] = chosen
        starts.append(values)
    costs = [from_afar.cost(from_afar.residual(values)) for values in starts]
    wide = [refine(from_afar, starts[int(k)], STEPS).values for k in np.argsort(costs)[:FINALISTS]]
    finalists = [refine(near, values, STEPS) for values in wide]
    finalists.sort(key=lambda solution: solution.cost)
    return [solution.values[: len(freedom.numbers)] for solution in finalists]


def open_start(equation: EquationErrorProblem, freedom: FreeParameters) -> np.ndarray:
    """Values (k,) of open parameters from the torque alone, by scaling; the given start may be far off.

    For a robust fit from a distant start all rows are outliers, and none of them pulls it closer.
    """
    by_torque = equation.under(Weighting.even(equation.rows, FAR)).by_torque_alone()
    found = fit(by_torque, null_hypothesis(freedom.model)).hypothesis.model()
    values = freedom.start.copy()
    for k, number in enumerate(freedom.numbers):
        part, name, parameter = split(number.path)
        value = found.effects[name].parameters[parameter] if part == "effects" else found.value(number.path)
        values[k] = min(max(value / number.shares[0], number.lower), number.upper)
    return values


def _own_start(misfit: EquationMisfit, values: np.ndarray, name: str, own: Sequence[int]) -> np.ndarray | None:
    """Values (k,) with a user's own effect at its regressed values, screened over all that the recordings cover.

    None if it is not a candidate, or shows nowhere.
    """
    equation, freedom = misfit.equation, misfit.freedom
    instance = freedom.model.effects[name]
    if not is_own(catalogue()[instance.effect]) or not equation.size:
        return None
    rest = replace(freedom, numbers=freedom.numbers[:-1]).at(values[:-1]).without_effect(name)
    found = screen(equation, fit(equation, null_hypothesis(rest)), [Candidate(instance.effect, instance.options)])
    if not found:
        return None
    begun = values.copy()
    for k in own:
        number = freedom.numbers[k]
        begun[k] = min(max(found[0].start[split(number.path)[2]], number.lower), number.upper)
    return begun


def explored(misfit: EquationMisfit, start: np.ndarray, enough: float, progress: Progress) -> Solution:
    """The best solution from ``start`` (k,) and from the starts that the catalogue lists."""
    best = solve(misfit, wave_start(misfit, np.append(start, 0.0)), enough=enough, progress=progress)
    model = misfit.freedom.model
    parted = any(instance.enabled and instance.effect in COMPLIANT_EFFECTS for instance in model.effects.values())
    if parted and best.misfit < CLEARLY_MORE * misfit.rows:
        return best
    better = best = refine(misfit, best.values, 0)
    for k, number in enumerate(misfit.freedom.numbers):
        part, name, parameter = split(number.path)
        if part != "effects" or model.effects[name].effect in COMPLIANT_EFFECTS:
            continue
        effect = table_in(catalogue()[model.effects[name].effect], model.units)
        own = [j for j, other in enumerate(misfit.freedom.numbers) if split(other.path)[:2] == (part, name)]
        if k == own[0] and (begun := _own_start(misfit, better.values, name, own)) is not None:
            progress(f"trying all starts of {name}")
            better = min(better, refine(misfit, begun, TRIED), key=lambda solution: solution.cost)
        starts = next(p.starts for p in effect.parameters if p.name == parameter)
        if len(starts) < 2:
            continue
        progress(f"trying other starts of {name}.{parameter}")
        for value in starts:
            trial = better.values.copy()
            trial[own] = misfit.freedom.start[own]  # a size that has shrunk to nothing would hide its location
            trial[k] = value
            found = refine(misfit, trial, TRIED)
            if found.cost < better.cost:
                better = found
    return best if better is best else solve(misfit, better.values, enough=enough, progress=progress)


def wave_start(misfit: EquationMisfit, start: np.ndarray) -> np.ndarray:
    """Values (k,) with amplitudes and phases of waves from a linear regression; ``start`` if that is not better.

    A wave with the wrong phase shrinks to nothing before its phase changes, and then has no gradient to change it.
    """
    found = waves(misfit.freedom)
    if not found:
        return start
    rest = start.copy()
    rest[[size for size, _ in found]] = 0.0
    left = misfit.residual(rest)
    weights = misfit.weights(left)
    others = [k for k in range(len(start)) if k not in {place for pair in found for place in pair}]
    columns = [misfit.slopes(rest, weights)[:, others]]
    for size, angle in found:
        for turned in (0.0, 0.5 * math.pi):
            one = rest.copy()
            one[size] = misfit.freedom.numbers[size].scale
            one[angle] = turned
            columns.append(((left - misfit.residual(one)) / one[size] * weights)[:, None])
    parts, *_ = np.linalg.lstsq(np.concatenate(columns, axis=1), left * weights, rcond=1e-9)
    better = rest
    for (size, angle), (plain, quarter) in zip(found, parts[len(others) :].reshape(-1, 2), strict=True):
        better[size] = min(math.hypot(plain, quarter), misfit.freedom.numbers[size].upper)
        better[angle] = math.atan2(quarter, plain)
    return better if misfit.cost(misfit.residual(better)) < misfit.cost(misfit.residual(start)) else start


def _widths(equation: EquationErrorProblem, model: Model) -> tuple[float, ...]:
    """Backlash widths [rad] suggested by the encoder difference at reversals, less the model's own encoder errors."""
    for name, instance in model.active.items():
        if instance.effect in COMPLIANT_EFFECTS:
            model = model.without_effect(name)
    spread = encoder_spread(equation, null_hypothesis(model))
    return tuple(spread * share for share in WIDTHS) if spread > 0.0 else ()
