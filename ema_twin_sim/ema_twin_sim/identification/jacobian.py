"""Slopes of a prediction with respect to the free parameters of its hypothesis."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..model import EffectInstance
from ..parallel import predictions
from .equation import EquationErrorProblem
from .hypothesis import DRY_SCALE, LAG, Free, Hypothesis
from .prediction import Prediction, Predictor, acts_at_the_motor

AT_THE_MOTOR = ("scale.inertia", DRY_SCALE)  # if the output has its own parameters


def jacobian(
    problem: EquationErrorProblem,
    h: Hypothesis,
    predicted: Prediction,
    weights: np.ndarray,
    known: Mapping[str, np.ndarray] | None = None,
    predictor: Predictor | None = None,
) -> np.ndarray:
    """Slopes of the weighted prediction (m, k) to the free parameters; ``known`` slopes (unweighted) are reused.

    ``predictor`` is what made the prediction, if that was not the problem itself.
    """
    known = known or {}
    predictor = predictor or problem
    sought = dict.fromkeys(
        free.path.split(".")[1] for free in h.free if free.path.startswith("effects.") and free.path not in known
    )
    now = {name: h.instance(name) for name in sought}
    torques = {name: problem.alone(predicted, instance) for name, instance in now.items()}
    lower, upper = problem.bounds(h)
    steps = [inner_step(*of) for of in zip(h.values, lower, upper, (free.step for free in h.free), strict=True)]
    moved = [h.put({free.path: h.values[k] + steps[k]}) for k, free in enumerate(h.free)]
    two_inertia = predicted.plant["two_inertia"][0] != 0.0

    def at_the_motor(free: Free) -> bool:
        kind, name, *_ = free.path.split(".")
        return acts_at_the_motor(now[name]) if kind == "effects" else free.path in AT_THE_MOTOR

    def moves_output(free: Free) -> bool:
        kind, *rest = free.path.split(".")
        if free.path in known or free.path == LAG or kind == "basis":
            return False
        return not at_the_motor(free) and (kind != "effects" or torques[rest[0]] is None)

    moving = [k for k, free in enumerate(h.free) if two_inertia and moves_output(free)]
    simulated = dict(zip(moving, predictor.rows_of([moved[k] for k in moving]), strict=True)) if moving else {}

    def column(k: int) -> np.ndarray:
        free = h.free[k]
        if free.path in known:
            return known[free.path] * weights
        if free.path.startswith("basis."):
            _, name, place = free.path.split(".")
            return problem.generic_bases[name][:, int(place)] * weights
        if free.path == LAG:
            rows = np.zeros(problem.rows)
            rows[: problem.size] = problem.rate / problem.noise
            return problem.whitened(rows) * weights
        kind, _, rest = free.path.partition(".")
        if kind == "effects":
            name, _, parameter = rest.partition(".")
            held, here = now[name], torques[name]
            if here is not None:
                values = {**held.parameters, parameter: held.parameters[parameter] + steps[k]}
                there = problem.alone(predicted, EffectInstance(held.effect, held.options, values))
                assert there is not None  # it acts alone at all parameter values
                return (there - here) / steps[k] * weights
        if k in simulated:
            there = simulated[k]
        else:
            beside = predicted if two_inertia and at_the_motor(free) else None
            there = predictor.predict(moved[k], beside=beside).rows
        return problem.centred((there - predicted.rows) / steps[k], weights) * weights

    columns = list(predictions(problem.samples, column, range(len(h.free))))
    return np.array(columns).reshape(len(columns), problem.rows).T  # each column stays in one piece


def inner_step(value: float, lower: float, upper: float, step: float) -> float:
    """Finite-difference step within the bounds: upwards if there is room, otherwise downwards.

    If there is room on neither side, the step goes to the farther bound, so that no model gets an impossible value.
    """
    above, below = upper - value, value - lower
    if above >= step:
        return step
    if below >= step:
        return -step
    farther = above if above >= below else -below
    if farther:
        return farther
    # A held parameter has no free side: step towards zero, but not to it, since an inertia of zero is impossible.
    return -min(step, 0.5 * value) if value > 0.0 else -step
