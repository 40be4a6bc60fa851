"""Misfit of the method ``equation``: the torque that the measured motion needs, and the encoder difference."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..criteria import BESIDE_IMPACTS, DAMPING_ERROR, LAG_TOLERANCE, SIDES_ERROR
from ..identification.equation import EquationErrorProblem
from ..identification.hypothesis import LAG, Free, Hypothesis
from ..identification.jacobian import jacobian
from ..identification.null_hypothesis import LAG_LIMIT, LAG_STEP
from ..identification.weighting import Weighting
from ..model import EffectInstance, Model
from ..model.roles import DRY_FRICTION, PLAY, SPRING
from ..plant.driven_output import RESOLVED
from ..simulation.assembly import assemble
from ..simulation.sensor_noise import counter_noise
from .free_parameters import FreeParameter, FreeParameters
from .misfit import Last

BLIND = ("drive.", "sensors.", "machine.torque_constant")
"""Prefixes of paths that do not appear in the equation."""
LAG_NUMBER = FreeParameter(LAG, (), (), "s", -LAG_LIMIT, LAG_LIMIT, LAG_TOLERANCE, LAG_STEP, (0.0, LAG_TOLERANCE))
ONE_SIDED = (f"effects.{DRY_FRICTION}", "machine.motor_inertia", "machine.output_inertia")


@dataclass(frozen=True, eq=False)
class ModelHypothesis(Hypothesis):
    """A hypothesis as in discovery, with the free parameters of a fit: the effects are the model's own."""

    freedom: FreeParameters

    def model(self) -> Model:
        """The model at the current values."""
        return self._model

    @cached_property
    def _model(self) -> Model:
        return self.freedom.at(self.values)

    def instance(self, name: str) -> EffectInstance:
        """An effect at the current values."""
        return self._model.effects[name]


class EquationMisfit:
    """The equation error over all recordings, in units of noise; the last parameter is the lag of the current."""

    def __init__(self, equation: EquationErrorProblem, freedom: FreeParameters) -> None:
        self.variance = equation.correlation
        self.freedom = FreeParameters(
            freedom.model, (*freedom.numbers, LAG_NUMBER), np.append(freedom.start, 0.0), freedom.notes
        )
        self.rows = equation.rows
        self.parts = equation.parts
        self._hypothesis = ModelHypothesis(freedom.model, {}, (), self.freedom.start, self.freedom)
        # an output with backlash is thrown about: outliers must not dominate from the start
        self._most = BESIDE_IMPACTS if assemble(freedom.model).plant["two_inertia"][0] != 0.0 else math.inf
        self.equation = equation
        if math.isfinite(self._most):
            self.equation = equation.under(Weighting.even(self.rows, self._most))
        self._predict = Last(lambda values: equation.predict(self._at(values)))  # under any weighting of its rows

    def with_outliers_from(self, scale: float) -> EquationMisfit:
        """The same misfit with one outlier scale in all rows."""
        other = copy(self)
        other.equation = self.equation.under(Weighting.even(self.rows, scale))
        return other

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Measured minus predicted (m,) at these values (k,)."""
        with np.errstate(all="ignore"):  # if no step resolves a stiffness, the cost is NaN and the step is rejected
            return self.equation.residual(self._predict(values))

    def slopes(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weighted slopes of the prediction (m, k) with respect to each parameter."""
        with np.errstate(all="ignore"):
            slopes = jacobian(self.equation, self._at(values), self._predict(values), weights)
        return np.nan_to_num(slopes, posinf=0.0, neginf=0.0)

    def zero_shift(self, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Weighted change of the prediction (m,) if every motor counter's zero is off by its noise."""
        shift = counter_noise(self.freedom.model, "motor")
        moved = self.equation.with_motor_zeros_off(shift)
        there = moved.predict(self._at(values)).rows
        return self.equation.centred(there - self._predict(values).rows, weights) * weights

    def systematic(self, values: np.ndarray) -> np.ndarray:
        """Systematic error of each parameter in a two-inertia model (zero otherwise).

        There the output's motion is not measured, and the samples do not resolve its contact. A stiffer contact is
        replaced by a softer one, whose deflection looks like backlash. The parameters of the output, and its damping,
        are determined only through a motor speed that is sampled and smoothed.
        """
        found = np.zeros(len(values))
        plant = assemble(self.freedom.at(values)).plant[0]
        if plant["two_inertia"] == 0.0:
            return found
        softest = plant["output_inertia"] * RESOLVED**2
        for k, number in enumerate(self.freedom.numbers):
            if number.path == f"effects.{PLAY}.width" and plant["contact_stiffness"] > softest:
                found[k] = 2.0 * plant["output_dry"] / softest / plant["gear_ratio"]
            elif number.path.startswith(ONE_SIDED):
                found[k] = SIDES_ERROR * values[k]
            elif number.path == f"effects.{SPRING}.damping":
                found[k] = DAMPING_ERROR * values[k]
        return found

    def weights(self, residual: np.ndarray) -> np.ndarray:
        """Square roots (m,) of the row weights, which decrease for outliers."""
        return self.equation.weights(residual)

    def cost(self, residual: np.ndarray) -> float:
        """Cauchy misfit."""
        with np.errstate(all="ignore"):
            return self.equation.misfit(residual)

    def reweigh(self, residual: np.ndarray) -> bool:
        """Let outliers begin where the bulk of each part ends; return whether that changed much."""
        weighting = self.equation.reweighed(residual, self._most)
        changed = weighting is not self.equation.weighting
        self.equation = self.equation.under(weighting)
        return changed

    def _at(self, values: np.ndarray) -> ModelHypothesis:
        free = tuple(
            # the shortcut for an effect that acts alone does not support tied parameters
            Free(n.path if len(n.paths) < 2 else f"tied.{n.path}", n.lower, n.upper, n.step * n.slope(value))
            for n, value in zip(self.freedom.numbers, values, strict=True)
        )
        return replace(self._hypothesis, free=free, values=values)
