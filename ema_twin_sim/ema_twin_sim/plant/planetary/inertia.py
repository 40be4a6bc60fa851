"""Division of the gearbox inertia among its wheels, and the natural frequencies of the wheels on their teeth.

The thesis gives one value, reduced to the sun (table A.1). The inertias of its script (I_sol = 1950) are kg mm^2 and
for solid steel; wheels of these dimensions, even printed, have some two hundred times the inertia of table A.1. So the
wheels' inertias are parameters, by default in the proportions of solid discs and scaled to the given value.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .displacements import CARRIER, FIRST_PLANET, OUTPUT, ROTATIONS, SUN, stiffness_matrix
from .geometry import OUTPUT_MESH, PLANETS, SUN_MESH, Gearing
from .mesh_table import AHEAD, ENTERING

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TrainInertia:
    """Inertias of sun, one planet about its own axis, and carrier [kg m^2], and mass of one planet [kg].

    The carrier's excludes the planets. The output ring's belongs to the driven load.
    """

    sun: float
    planet: float
    planet_mass: float
    carrier: float


def default_inertia(gearing: Gearing, gearbox_inertia: float) -> TrainInertia:
    """Inertias in the proportions of solid discs, whose sum reduced to the sun is ``gearbox_inertia`` [kg m^2].

    Discs of the pitch radius and one face width for each toothing, all of one material. No carrier: the thesis says
    (appendix A) that there is none, the planets being held by their meshes.
    """
    sun, planet = gearing.meshes[SUN_MESH].first_pitch_radius, gearing.meshes[SUN_MESH].second_pitch_radius
    second = gearing.meshes[OUTPUT_MESH].first_pitch_radius
    discs = TrainInertia(0.5 * sun**4, 0.5 * (planet**4 + second**4), planet**2 + second**2, 0.0)
    scale = gearbox_inertia / reduced_inertia(gearing, discs)
    return TrainInertia(scale * discs.sun, scale * discs.planet, scale * discs.planet_mass, scale * discs.carrier)


def reduced_inertia(gearing: Gearing, inertia: TrainInertia) -> float:
    """Inertia [kg m^2] at the motor: J_s + 3 J_p (w_c - W)^2 + (3 m_p a^2 + J_c) w_c^2, speeds per sun's.

    A planet spins at w_c - W (W: relative to the carrier, against the sun's way) while its mass orbits at radius a.
    """
    carrier, spin = gearing.carrier_ratio, gearing.carrier_ratio - gearing.planet_ratio
    orbit = PLANETS * inertia.planet_mass * gearing.centre_distance**2 + inertia.carrier
    return inertia.sun + PLANETS * inertia.planet * spin**2 + orbit * carrier**2


def inertia_matrix(gearing: Gearing, inertia: TrainInertia, motor_inertia: float, output_inertia: float) -> Array:
    """Matrix (6, 6) [kg m^2] of the six rotations; the motor turns with the sun; both inertias at the fast shaft."""
    matrix = np.zeros((ROTATIONS, ROTATIONS))
    matrix[SUN, SUN] = motor_inertia + inertia.sun
    matrix[CARRIER, CARRIER] = inertia.carrier + PLANETS * inertia.planet_mass * gearing.centre_distance**2
    matrix[OUTPUT, OUTPUT] = output_inertia * gearing.ratio**2
    for planet in range(FIRST_PLANET, FIRST_PLANET + PLANETS):
        spin = np.zeros(ROTATIONS)
        spin[CARRIER], spin[planet] = 1.0, -1.0
        matrix += inertia.planet * np.outer(spin, spin)
    return matrix


def natural_frequencies(
    gearing: Gearing, table: Array, inertia: TrainInertia, motor_inertia: float, output_inertia: float
) -> Array:
    """Natural frequencies [rad/s] (6, rising, the first 0) with every mesh at its stiffest; inertias at the fast shaft.

    The highest limits an explicit step: up to 2 over it an undamped oscillation does not grow.
    """
    stiffest = table[:, :, [ENTERING, AHEAD]].sum(axis=2).max(axis=1)
    stiffness = stiffness_matrix(gearing, np.repeat(stiffest[:, np.newaxis], PLANETS, axis=1))
    # Symmetric, with the inertia's Cholesky factor; so also accurate for the zero frequency of the free rotation.
    factor = np.linalg.inv(np.linalg.cholesky(inertia_matrix(gearing, inertia, motor_inertia, output_inertia)))
    squares = np.linalg.eigvalsh(factor @ stiffness @ factor.T)
    return np.sqrt(np.maximum(squares, 0.0))


def equivalent_masses(gearing: Gearing, inertia: TrainInertia, motor_inertia: float) -> Array:
    """Equivalent masses [kg] of the three kinds of mesh along the line of action: 1/m = r_1^2/J_1 + r_2^2/J_2.

    The rings count as fixed. Used for a mesh's damping, 2 ratio sqrt(k m). The script uses the wheels' masses instead.
    """
    planet = (
        np.array([gearing.planet_radius, gearing.planet_radius, gearing.second_planet_radius]) ** 2 / inertia.planet
    )
    sun = np.array([gearing.sun_radius**2 / (motor_inertia + inertia.sun), 0.0, 0.0])
    return 1.0 / (planet + sun)


def shaft_stiffness(radius: float, length: float, shear_modulus: float) -> float:
    """Stiffness [N m/rad] of a round shaft of ``radius`` and ``length`` [m]: I_p G/L, I_p = pi/2 r^4 (eq. 3.1).

    ``shear_modulus`` is in Pa. Of the script's two shafts, one is set to zero and the other uses G = 0.33 E; for steel
    it is E/2.6.
    """
    return 0.5 * math.pi * radius**4 * shear_modulus / length


def shaft_damping(stiffness: float, inertia: float, damping_ratio: float) -> float:
    """Damping [N m s/rad] of a shaft of ``stiffness`` [N m/rad]: 2 ratio sqrt(k J), J [kg m^2] at the shaft.

    Eq. 3.2 prints the shaft's mass, which has the wrong dimension. J is 1/(1/J_1 + 1/J_2) of the inertias at both ends,
    as in the script: for a motor and a light gearbox, nearly the gearbox's.
    """
    return 2.0 * damping_ratio * math.sqrt(stiffness * inertia)
