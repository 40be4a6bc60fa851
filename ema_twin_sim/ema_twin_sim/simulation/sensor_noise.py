"""The noise floor of every compared signal: the residual that remains if the twin is correct."""

from __future__ import annotations

import math

import numpy as np

from ..model import Model
from ..plant.balance import balance_response
from ..plant.layout import STATE
from .assembly import assemble

_SETTLED = 400  # samples after which one sample's noise has decayed in the balance's filters


def noise_floors(model: Model, *, has_speed: bool = True, period: float | None = None) -> dict[str, float]:
    """RMSE per signal that remains if the twin is correct, SI.

    Current and speed: their sensors' white noise. Positions: the counter's noise and quantisation twice, since they
    count from one noisy first sample; the twin's own quantisation; and a lasting lag of the speed loop caused by the
    first sample's current noise, from which the drive's integrator starts. The unexplained torque: the noise of current
    and speed (or, if ``has_speed`` is false, of the motor counter used instead) through the filters of
    ``plant.balance`` at a sample ``period`` [s] (by default the model's).
    """
    current = model.value("sensors.current_noise")
    speed = model.value("sensors.speed_noise")
    one = {side: counter_noise(model, side) for side in ("motor", "output")}
    counter = {side: math.hypot(math.sqrt(2.0) * one[side], _count(model, side) / math.sqrt(12.0)) for side in one}
    integrator = current * model.value("machine.torque_constant")
    if model.value("drive.integral_limit") == 0.0:  # without an integrator there is no such lag
        integrator = 0.0
    lag = integrator * model.value("drive.integral_time") / max(model.value("drive.speed_gain"), 1e-12)
    period = period or model.value("sensors.sample_period")
    return {
        "current": current,
        "speed": speed,
        "motor_position": math.hypot(counter["motor"], lag),
        "output_position": math.hypot(counter["output"], lag / model.value("machine.gear_ratio")),
        "unexplained_torque": _balance_noise(model, current, speed if has_speed else one["motor"], has_speed, period),
    }


def counter_noise(model: Model, side: str) -> float:
    """Standard deviation of one sample of the ``motor`` or ``output`` counter [rad of its own shaft]: its noise and its
    quantisation.
    """
    return _count(model, side) * math.hypot(model.value(f"sensors.{side}_encoder_noise"), math.sqrt(1.0 / 12.0))


def _count(model: Model, side: str) -> float:
    return model.turn / model.value(f"sensors.{side}_encoder_counts")


def _balance_noise(model: Model, current: float, motion: float, has_speed: bool, period: float) -> float:
    plant = assemble(model).plant
    by_current = balance_response(plant, np.zeros(1, STATE), period, has_speed, True, _SETTLED)
    by_motion = balance_response(plant, np.zeros(1, STATE), period, has_speed, False, _SETTLED)
    return math.hypot(current * float(np.linalg.norm(by_current)), motion * float(np.linalg.norm(by_motion)))
