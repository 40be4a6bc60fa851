"""The sensors' noise floor of every compared signal: what remains of a residual when the twin is right."""

from __future__ import annotations

import math

import numpy as np

from ..model import Model
from ..plant.balance import balance_response
from ..simulation.assembly import assemble

_SETTLED = 400  # samples after which the balance's filters have forgotten one sample's noise


def noise_floors(model: Model, *, has_speed: bool = True) -> dict[str, float]:
    """Standard deviation of the noise per signal, SI: the sensor's white noise, and its quantisation for the counters.

    The unexplained torque's is that of the current and of the speed (or, where ``has_speed`` is false, of the motor
    counter that the speed is then taken from) through the filters of ``plant.balance``.
    """
    current = model.value("sensors.current_noise")
    speed = model.value("sensors.speed_noise")
    motor, output = (
        math.sqrt(model.value(f"sensors.{side}_encoder_noise") ** 2 + 1.0 / 12.0)
        * (2.0 * math.pi / model.value(f"sensors.{side}_encoder_counts"))
        for side in ("motor", "output")
    )
    return {
        "current": current,
        "speed": speed,
        "motor_position": motor,
        "output_position": output,
        "unexplained_torque": _balance_noise(model, current, speed if has_speed else motor, has_speed),
    }


def _balance_noise(model: Model, current: float, motion: float, has_speed: bool) -> float:
    plant = assemble(model).plant
    period = model.value("sensors.sample_period")
    by_current = balance_response(plant, period, has_speed, True, _SETTLED)
    by_motion = balance_response(plant, period, has_speed, False, _SETTLED)
    return math.hypot(current * float(np.linalg.norm(by_current)), motion * float(np.linalg.norm(by_motion)))
