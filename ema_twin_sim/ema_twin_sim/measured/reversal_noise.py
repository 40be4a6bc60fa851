"""What a reversal adds to the noise of the torque: while a shaft creeps or stands, its friction is anywhere between the
levels of both directions, and no speed tells where.
"""

from __future__ import annotations

import numpy as np

from ..criteria import STANDSTILL
from ..model import Model
from ..simulation.assembly import assemble
from .smoothing import smooth


def reversal_noise(speed: np.ndarray, kernel: np.ndarray, model: Model) -> np.ndarray:
    """Standard deviation [N m] (n,) of a smoothed torque by the friction whose direction is not known there.

    ``speed`` (n,) [rad/s] is the motor's, ``kernel`` smooths torques. It is the level of the model's dry friction times
    the kernel's weight of the samples that are slow; where the speed passes through zero between two samples, half of
    each is. A model that bends its bristle before it slides knows better.
    """
    plant = assemble(model).plant[0]
    if plant["bristle_stiffness"] > 0.0:
        return np.zeros(len(speed))
    unknown = (np.abs(speed) < STANDSTILL).astype(float)
    passing = np.flatnonzero(speed[1:] * speed[:-1] < 0.0)
    for sample in (passing, passing + 1):
        unknown[sample] = np.maximum(unknown[sample], 0.5)
    return float(plant["motor_dry"] + plant["output_dry"]) * smooth(unknown, kernel)
