"""Relative displacements of the teeth along the lines of action (thesis, eqs 3.17 to 3.28).

Extended to the second planet toothing and the output ring; the thesis stops at the carrier and divides by 124. The six
rotations are sun, three planets relative to the carrier (positive against the sun's direction), carrier, output ring.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .geometry import PLANETS, Gearing

SUN, FIRST_PLANET, CARRIER, OUTPUT = 0, 1, 4, 5
ROTATIONS = 6

Array = NDArray[np.float64]


def displacements(gearing: Gearing) -> Array:
    """Matrix (9, 6) of the displacements [m] per rotation [rad]: sun, fixed ring and output ring meshes.

    delta_s = r_s (th_s - th_c) - r_p th_p; delta_r = r_p th_p - r_r th_c; delta_o = r_p2 th_p - r_o (th_c - th_o).
    Its transpose gives the torques on the six rotations that balance the mesh forces.
    """
    matrix = np.zeros((3, PLANETS, ROTATIONS))
    sun, ring, output = matrix
    sun[:, SUN], sun[:, CARRIER] = gearing.sun_radius, -gearing.sun_radius
    ring[:, CARRIER] = -gearing.ring_radius
    output[:, CARRIER], output[:, OUTPUT] = -gearing.output_ring_radius, gearing.output_ring_radius
    for i in range(PLANETS):
        sun[i, FIRST_PLANET + i] = -gearing.planet_radius
        ring[i, FIRST_PLANET + i] = gearing.planet_radius
        output[i, FIRST_PLANET + i] = gearing.second_planet_radius
    return matrix.reshape(3 * PLANETS, ROTATIONS)


def stiffness_matrix(gearing: Gearing, stiffness: Array) -> Array:
    """Matrix (..., 6, 6) [N m/rad] of the train for mesh stiffnesses (..., 3 meshes, 3 planets) [N/m]."""
    matrix = displacements(gearing)
    return matrix.T @ (stiffness.reshape(*stiffness.shape[:-2], -1, 1) * matrix)


def rigid_motion(gearing: Gearing) -> Array:
    """The six rotations per rotation of the sun with rigid teeth."""
    planets = [gearing.planet_ratio] * PLANETS
    return np.array([1.0, *planets, gearing.carrier_ratio, 1.0 / gearing.ratio])
