"""What a model's sensors add to the samples of a twin and its bench."""

from __future__ import annotations

import math

import numpy as np

from ..model import Model
from ..plant.balance import balance_response
from ..plant.layout import STATE
from .assembly import assemble

_SETTLED = 400  # samples after which one sample's noise has decayed in the balance's filters


class Sensors:
    """What a model's sensors add to a sample, SI."""

    def __init__(self, model: Model, has_speed: bool, period: float) -> None:
        """Of a ``model`` that is sampled every ``period`` [s], with a measured speed or without."""
        self.model, self.has_speed, self.period = model, has_speed, period
        self.current = model.value("sensors.current_noise")
        self.speed = model.value("sensors.speed_noise")
        integrator = self.current * model.value("machine.torque_constant")
        if model.value("drive.integral_limit") == 0.0:  # without an integrator there is no such lag
            integrator = 0.0
        lag = integrator * model.value("drive.integral_time") / max(model.value("drive.speed_gain"), 1e-12)
        self.lag = {"motor": lag, "output": lag / model.value("machine.gear_ratio")}

    def position(self, side: str) -> float:
        """Noise of a position: of two samples of its counter, of the twin's, and the lag."""
        one = counter_noise(self.model, side)
        both = math.hypot(math.sqrt(2.0) * one, _count(self.model, side) / math.sqrt(12.0))
        return math.hypot(both, self.lag[side])

    def encoder_difference(self) -> float:
        """Noise of the output's position minus the motor's [rad of the output]."""
        motor, output = (counter_noise(self.model, side) for side in ("motor", "output"))
        return math.hypot(output, motor / self.model.value("machine.gear_ratio"))

    def balance(self) -> float:
        """Noise of the unexplained torque."""
        motion = self.speed if self.has_speed else counter_noise(self.model, "motor")
        plant = assemble(self.model).plant
        by_current, by_motion = (
            balance_response(plant, np.zeros(1, STATE), self.period, self.has_speed, of_current, _SETTLED)
            for of_current in (True, False)
        )
        return math.hypot(self.current * float(np.linalg.norm(by_current)), motion * float(np.linalg.norm(by_motion)))


def counter_noise(model: Model, side: str) -> float:
    """Standard deviation of one sample of the ``motor`` or ``output`` counter [rad of its own shaft]: its noise and its
    quantisation.
    """
    return _count(model, side) * math.hypot(model.value(f"sensors.{side}_encoder_noise"), math.sqrt(1.0 / 12.0))


def _count(model: Model, side: str) -> float:
    return model.turn / model.value(f"sensors.{side}_encoder_counts")
