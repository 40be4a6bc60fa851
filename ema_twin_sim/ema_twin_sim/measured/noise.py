"""Noise floor of a set of recordings: everything that judges, compares or shows them uses this one."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ema_bench_replay.recording import Recording

from ..model import Model
from ..simulation.compared_signals import noise_floors
from .quieter_motion import as_measured
from .scales import begun_near, to_rotary_equivalent

NoiseFloor = dict[str, float]
"""RMSE by compared signal that remains with a right twin, in SI; of the drum for a linear machine."""


def noise_of(recordings: Sequence[Recording], model: Model) -> NoiseFloor:
    """The noise floor of native recordings, pooled over their samples.

    The sensors are those of the model file. Open inertia and friction are estimated from the recordings, so that a
    model has the same noise floor before and after a fit: a start value says nothing about the sensors.
    """
    if not recordings:
        return noise_floors(to_rotary_equivalent(recordings, model)[1])
    taken = as_measured(recordings, model)
    recordings, near = to_rotary_equivalent(taken, begun_near(taken, model, absent=True))
    kinds = {(r.has("speed"), r.sample_period) for r in recordings}
    floors = {kind: noise_floors(near, has_speed=kind[0], period=kind[1]) for kind in kinds}
    each = [floors[r.has("speed"), r.sample_period] for r in recordings]
    lengths = [len(r) for r in recordings]  # errors are pooled over samples, so is this
    return {
        name: math.sqrt(sum(n * floor[name] ** 2 for n, floor in zip(lengths, each, strict=True)) / sum(lengths))
        for name in each[0]
    }
