"""The torque that a model needs for a measured motion, and what its twin shows beside the measured signals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording

from ..model import Model
from ..plant.measured_motion import REQUIRED, inverse_dynamics
from ..plant.output_side import LOW_SPEED
from .angle_origins import angle_origins
from .assembly import Assembly


def required_torque(assembly: Assembly, recording: Recording, motion: np.ndarray) -> np.ndarray:
    """Torque [N m] (n,) for a recording's motion (n, 7), without the motor's own inertia."""
    ratio = float(assembly.plant["gear_ratio"][0])
    motor, output = angle_origins(recording.motor_angle_origin, recording.output_angle_origin, ratio)
    required = np.empty((len(motion), len(REQUIRED)))
    fading = 0.0 if recording.of_points else LOW_SPEED
    inverse_dynamics(assembly.plant, assembly.effects, motion, motor, output, np.zeros(0), False, fading, required)
    return required[:, 0]


def twin_of(recording: Recording, model: Model, signals: Mapping[str, np.ndarray]) -> Recording:
    """A model's recording beside a measured one, with the twin's signals (n,)."""
    return replace(recording, signals=signals, metadata={"model": model.name}, warnings=())
