"""Noise of the judged rows: of a smoothed torque and encoder difference, of rounding, and after hard acceleration."""

from __future__ import annotations

import math

import numpy as np

from ..criteria import HARD
from ..model import Model
from ..reading_noise import beside_fast_signal, reading_noise, reading_step
from ..simulation.sensor_noise import counter_noise


def shaken(hit: np.ndarray) -> np.ndarray:
    """Factor (n,) on the noise after the largest acceleration (n,) [rad/s²] shortly before."""
    return np.sqrt(1.0 + (hit / HARD) ** 2)


def torque_noise(current: np.ndarray, raw: np.ndarray, kernel: np.ndarray, model: Model) -> float:
    """Standard deviation [N m] of a smoothed current's torque, from its white noise and its resolution.

    Steps that are wide relative to the noise are not white: smoothing does not reduce them. They are taken from the
    ``raw`` values as recorded, since interpolated samples have no steps.
    """
    smoothed = float(np.linalg.norm(kernel))
    rounding = rounding_noise(raw, model)
    white = max(
        beside_fast_signal(reading_noise(current), current), model.value("sensors.current_noise") if rounding else 0.0
    )
    return model.value("machine.torque_constant") * math.hypot(white * smoothed, rounding)


def rounding_noise(raw: np.ndarray, model: Model, read: float = 0.0) -> float:
    """Standard deviation [A] of the rounding of a current; zero if its steps are no wider than its noise.

    The noise is the model's, or what was ``read`` off the recording if the model gives none.
    """
    step = reading_step(raw)
    return step / math.sqrt(12.0) if step > 2.0 * max(model.value("sensors.current_noise"), read) else 0.0


def encoder_noise(model: Model) -> float:
    """Standard deviation [rad, slow shaft] of the encoder difference."""
    return math.hypot(counter_noise(model, "output"), counter_noise(model, "motor") / model.value("machine.gear_ratio"))
