"""Noise of the acceleration: what it adds to the misfit of an inertia, which a fit must not make small.

An acceleration is measured with noise, and a regression on it gives an inertia that is too small by the share of the
noise in the acceleration's power (errors in variables; Fuller, Measurement Error Models, 1987, section 1.2). The noise
is known, so what it adds to the sum of squares on average, noise power times inertia squared, is subtracted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .equation import EquationErrorProblem, accelerated_inertia, torque_scale
from .hypothesis import Hypothesis
from .prediction import Prediction

SCALE = "scale.inertia"
MOST = 0.75  # of the acceleration's power that may be noise: beyond, it is not known well enough to subtract it


@dataclass(frozen=True)
class AccelerationNoise:
    """The sum of squares that the noise of the acceleration adds, ``power`` [1/(kg m^2)^2] times inertia squared.

    ``place`` is that of the inertia's scale among the free parameters.
    """

    place: int
    power: float

    @classmethod
    def of(
        cls, h: Hypothesis, p: EquationErrorProblem, at: Prediction, weights: np.ndarray
    ) -> AccelerationNoise | None:
        """The noise in the rows of a problem; None if the inertia is not free, or the gearbox is simulated."""
        place = next((k for k, free in enumerate(h.free) if free.path == SCALE), None)
        if place is None or not p.size or at.plant["two_inertia"][0] != 0.0:
            return None
        per_unit = weights[: p.size] / (torque_scale(at.plant[0]) * p.noise)
        noise, signal = (float(np.sum((per_unit * of) ** 2)) for of in (p.acceleration_noise, p.acceleration))
        return cls(place, min(noise, MOST * signal)) if noise > 0.0 else None

    def cost(self, at: Prediction) -> float:
        """What the noise adds to the misfit of a prediction."""
        return self.power * accelerated_inertia(at.plant[0]) ** 2

    def taken_out(self, h: Hypothesis, at: Prediction, square: np.ndarray, slope: np.ndarray) -> None:
        """Subtract the noise from the normal equations: ``square`` (k, k) and ``slope`` (k,), changed in place."""
        inertia = accelerated_inertia(at.plant[0])
        per_scale = inertia / h.values[self.place]
        square[self.place, self.place] -= self.power * per_scale**2
        slope[self.place] += self.power * inertia * per_scale
