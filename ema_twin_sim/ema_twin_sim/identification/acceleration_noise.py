"""Noise of the acceleration: what it adds to the misfit of an inertia, which a fit must not make small.

An acceleration is measured with noise, and a regression on it gives an inertia that is too small by the share of the
noise in the acceleration's power (errors in variables; Fuller, Measurement Error Models, 1987, section 1.2). The noise
is known, so what it adds to the sum of squares on average, noise power times inertia squared, is subtracted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..effects import catalogue
from ..simulation.assembly import assemble
from .equation import EquationErrorProblem, accelerated_inertia, torque_scale
from .hypothesis import Hypothesis
from .prediction import Prediction

SCALE = "scale.inertia"
MOST = 0.75  # of the acceleration's power that may be noise: beyond, it is not known well enough to subtract it


@dataclass(frozen=True, eq=False)
class AccelerationNoise:
    """The sum of squares that the noise of the acceleration adds: ``power`` [1/(kg m^2)^2] times inertia squared.

    ``slopes`` (k,) [kg m^2] are those of the inertia to the free parameters, in which it is linear.
    """

    power: float
    slopes: np.ndarray

    @classmethod
    def of(
        cls, h: Hypothesis, p: EquationErrorProblem, at: Prediction, weights: np.ndarray
    ) -> AccelerationNoise | None:
        """The noise in the rows of a problem; None if the inertia is not free, or the gearbox is simulated."""
        if not p.size or at.plant["two_inertia"][0] != 0.0 or all(free.path != SCALE for free in h.free):
            return None
        per_unit = weights[: p.size] / (torque_scale(at.plant[0]) * p.noise)
        noise, signal = (float(np.sum((per_unit * of) ** 2)) for of in (p.acceleration_noise, p.acceleration))
        return cls(min(noise, MOST * signal), _slopes(h, at)) if noise > 0.0 else None

    def cost(self, at: Prediction) -> float:
        """What the noise adds to the misfit of a prediction."""
        return self.power * accelerated_inertia(at.plant[0]) ** 2

    def taken_out(self, at: Prediction, square: np.ndarray, slope: np.ndarray) -> None:
        """Subtract the noise from the normal equations: ``square`` (k, k) and ``slope`` (k,), changed in place."""
        square -= self.power * np.outer(self.slopes, self.slopes)
        slope += self.power * accelerated_inertia(at.plant[0]) * self.slopes


def _slopes(h: Hypothesis, at: Prediction) -> np.ndarray:
    """Slopes (k,) of the inertia to the free parameters: its scale, and sizes of effects that act over acceleration."""
    inertia = accelerated_inertia(at.plant[0])
    over = {f"effects.{name}" for name, one in h.added.items() if catalogue()[one.effect].depends_on == "acceleration"}
    slopes = np.zeros(len(h.free))
    for k, free in enumerate(h.free):
        if free.path == SCALE or free.path.rpartition(".")[0] in over:
            moved = assemble(h.put({free.path: h.values[k] + free.step}).model())
            slopes[k] = (accelerated_inertia(moved.plant[0]) - inertia) / free.step
    return slopes
