"""Internal state of a twin of a finer fidelity: its wheels, mesh forces and energies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..plant.energy import ENERGIES, stored_in_meshes
from ..plant.layout import Fine
from ..plant.planetary.layout import LANE, MESHES, PLANETS, ROW
from .fidelity import FineParts


@dataclass(frozen=True)
class Wheels:
    """Wheels of a planetary train. Angles [rad] since the first sample, speeds [rad/s]; a planet's are absolute.

    ``forces`` and ``friction`` [N] (3 mesh types, 3 planets) along and across the lines of action: sun, ring, output.
    """

    sun_angle: float
    sun_speed: float
    carrier_angle: float
    carrier_speed: float
    planet_angles: np.ndarray
    planet_speeds: np.ndarray
    output_angle: float
    output_speed: float
    forces: np.ndarray
    friction: np.ndarray


@dataclass(frozen=True)
class Energies:
    """Energies [J]: works and losses since the start in ``booked`` (``plant.energy.ENERGIES``).

    ``stored`` is the present content: ``kinetic``, ``springs`` of the meshes, ``magnetic``.
    """

    booked: dict[str, float]
    stored: dict[str, float]


def wheels(fine: Fine, state: np.ndarray, ratio: float) -> Wheels:
    """The present state of a train's wheels."""
    lanes, moving = fine.lanes, fine.train_states[0]

    def rows(name: str) -> np.ndarray:
        return np.array([lanes[ROW[f"{name}_SUN"] + LANE * mesh :][:PLANETS] for mesh in range(len(MESHES))])

    return Wheels(
        sun_angle=float(moving["sun_angle"]),
        sun_speed=float(moving["sun_speed"]),
        carrier_angle=float(moving["carrier_angle"]),
        carrier_speed=float(moving["carrier_speed"]),
        planet_angles=lanes[ROW["SPIN"] :][:PLANETS].copy(),
        planet_speeds=lanes[ROW["SPIN_SPEED"] :][:PLANETS].copy(),
        output_angle=float(state["output_angle"][0]) / ratio,
        output_speed=float(state["output_speed"][0]) / ratio,
        forces=rows("FORCE"),
        friction=rows("FRICTION"),
    )


def energies(parts: FineParts, fine: Fine, plant: np.ndarray, state: np.ndarray, step: float) -> Energies:
    """Energies recorded since the start, and stored in a twin with integration step ``step`` [s]."""
    booked = dict(zip(ENERGIES, fine.energies.tolist(), strict=True))
    ratio = float(plant["gear_ratio"][0])
    speed, output_speed = float(state["motor_speed"][0]), float(state["output_speed"][0])
    input_inertia, output_inertia = float(plant["motor_inertia"][0]), float(plant["output_inertia"][0])
    stored = {"magnetic": 0.0, "springs": 0.0}
    wheels_kinetic = 0.0
    if parts.planetary:
        train, moving = (array.view(np.recarray)[0] for array in (fine.trains, fine.train_states))
        input_inertia = float(train["input_inertia"])
        now = wheels(fine, state, ratio)
        wheels_kinetic = 0.5 * float(
            train["carrier_inertia"] * now.carrier_speed**2 + train["planet_inertia"] * (now.planet_speeds**2).sum()
        )
        if train["shaft_stiffness"] > 0.0:
            wheels_kinetic += 0.5 * float(train["sun_inertia"]) * now.sun_speed**2
        stored["springs"] = stored_in_meshes(
            train, moving, fine.lanes, now.sun_angle, now.sun_speed, now.output_angle, now.output_speed, step
        )
    if parts.switching:
        winding, held = fine.windings[0], fine.winding_states[0]
        stored["magnetic"] = 0.5 * sum(
            float(winding["phase_inductance"] * winding[f"active_turns_{p}"] ** 2 * held[f"phase_current_{p}"] ** 2)
            for p in "uvw"
        )
    stored["kinetic"] = wheels_kinetic + 0.5 * (input_inertia * speed**2 + output_inertia * output_speed**2)
    return Energies(booked, stored)
