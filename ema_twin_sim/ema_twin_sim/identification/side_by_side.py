"""Simulate two-inertia models that differ only in parameter values, several at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..measured.observation import Observation
from ..measured.smoothing import smooth_many_at
from ..plant.layout import PLANT
from ..plant.measured_motion_many import LANE, inverse_dynamics_many
from ..plant.motion import MOTOR_ANGLE, TIME
from ..plant.sensors import as_encoder_shows
from ..simulation.assembly import Assembly
from .prediction import seen_output

LEAST = 3  # models from which on this is faster than one at a time


def groups(assemblies: Sequence[Assembly]) -> list[list[int]]:
    """Groups of models of the same structure: up to LANE each, and no group smaller than LEAST."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for k, assembly in enumerate(assemblies):
        plant, (addresses, places, _) = assembly.plant[0], assembly.effects
        if plant["two_inertia"] != 0.0:
            structure = (plant["gap"] > 0.0, plant["bristle_stiffness"] > 0.0, *addresses, *places)
            alike.setdefault(structure, []).append(k)
    parts = [ks[begin : begin + LANE] for ks in alike.values() for begin in range(0, len(ks), LANE)]
    return [part for part in parts if len(part) >= LEAST]


def simulate(models: Sequence[tuple[Assembly, np.ndarray]], o: Observation, t: slice, e: slice) -> None:
    """Write required torque [N m] and encoder difference [rad] of each model into its rows ``t`` and ``e``."""
    lanes = [assembly for assembly, _ in (*models, *[models[0]] * (LANE - len(models)))]
    plants = np.empty(LANE, PLANT)
    for m, assembly in enumerate(lanes):
        plants[m] = assembly.plant[0]
    seen = np.empty((len(o.motion) if plants["gap"][0] > 0.0 and len(o.encoder_rows) else 0, LANE))
    if len(seen):
        for m, plant in enumerate(plants):
            seen[:, m] = seen_output(o, plant)
    torque, output = np.empty((len(o.motion), LANE)), np.empty((len(o.motion), LANE))
    inverse_dynamics_many(
        plants,
        *lanes[0].effects[:2],
        np.stack([assembly.effects[2] for assembly in lanes]),
        o.motion,
        o.motor_origin,
        o.output_origin,
        seen,
        torque,
        output,
    )
    smoothed = np.empty((len(o.rows), LANE))
    smooth_many_at(torque, o.kernel, o.rows, smoothed)
    for m, (_, rows) in enumerate(models):
        rows[t] = smoothed[:, m]
    if not len(o.encoder_rows):
        return
    alone = o.motion[:, MOTOR_ANGLE] / plants["gear_ratio"][0]
    for m, plant in enumerate(plants):
        output[:, m] = as_encoder_shows(plant, o.motion[:, TIME], output[:, m], o.output_origin) - alone
    smoothed = np.empty((len(o.encoder_rows), LANE))
    smooth_many_at(output, o.kernel, o.encoder_rows, smoothed)
    for m, (_, rows) in enumerate(models):
        rows[e] = smoothed[:, m]
