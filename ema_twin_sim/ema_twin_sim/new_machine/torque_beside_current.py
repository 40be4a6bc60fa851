"""Whether a current and a torque recorded together are one thing in two units, as a motor's are, or two.

The current of a supply is its power over its voltage, and that of an induction motor magnetises it too: then the torque
says what drives the machine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import FEWEST_ROWS, SMALL, TOO_MUCH
from ..reading_noise import reading_noise


def not_proportional(recordings: Sequence[Recording]) -> float | None:
    """The share of the motor's torque (rms) that no factor times the current explains; None if it is small.

    Small is what both sensors' noise explains. Operating points, whose rows come in any order, tell no noise.
    """
    both = [r for r in recordings if r.has("current", "motor_torque")]
    parts = [_known(r) for r in both]
    current, torque = np.concatenate(parts, axis=1) if parts else np.zeros((2, 0))
    if len(torque) < FEWEST_ROWS or not current.any() or not torque.any():
        return None
    factor = float(current @ torque / (current @ current))
    share = math.sqrt(float(np.mean((torque - factor * current) ** 2) / np.mean(torque**2)))
    noises = [
        math.hypot(reading_noise(torque), factor * reading_noise(current))
        for (current, torque), recording in zip(parts, both, strict=True)
        if not recording.of_points
    ]
    noise = max(noises, default=0.0) / math.sqrt(float(np.mean(torque**2)))
    return share if share > max(SMALL, TOO_MUCH * noise) else None


def _known(recording: Recording) -> np.ndarray:
    """Current and torque (2, n) where both are known."""
    both = np.stack([recording.signals["current"], recording.signals["motor_torque"]])
    return both[:, np.isfinite(both).all(axis=0)]
