"""Stiffness of the whole train between its two shafts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .displacements import CARRIER, SUN, stiffness_matrix
from .geometry import Gearing
from .mesh_table import AHEAD, ENTERING
from .phases import mesh_phases

POSITIONS_PER_TOOTH = 32

Array = NDArray[np.float64]


def torsional_stiffness(gearing: Gearing, table: Array) -> tuple[float, float]:
    """Stiffness [N m/rad] at the fast shaft with the output locked, and at the slow shaft with the sun locked.

    From the mean stiffness of all meshes over a cycle; the slow one is the fast one times the ratio squared.
    """
    fast = float(np.mean(stiffness_over_positions(gearing, table)))
    return fast, fast * gearing.ratio**2


def stiffness_over_positions(gearing: Gearing, table: Array) -> Array:
    """Stiffness at the fast shaft [N m/rad], output locked, over one turn of the planets against their carrier.

    After that turn both toothings of the planets, and so all meshes, repeat. Wheels are at their rigid positions.
    """
    positions = POSITIONS_PER_TOOTH * gearing.planet_teeth
    teeth = np.array([gearing.planet_teeth, gearing.planet_teeth, gearing.second_planet_teeth])
    turned = np.arange(positions)[:, np.newaxis] * teeth / positions
    cycles = (mesh_phases(gearing) + turned[:, :, np.newaxis]) % 1.0  # (positions, meshes, planets)
    both = table[:, :, [ENTERING, AHEAD]].sum(axis=2)
    points = np.linspace(0.0, 1.0, both.shape[1])
    stiffness = np.stack([np.interp(cycles[:, mesh], points, both[mesh]) for mesh in range(len(both))], axis=1)
    free = slice(SUN, CARRIER + 1)  # all except the output ring, which is locked
    compliance = np.linalg.inv(stiffness_matrix(gearing, stiffness)[:, free, free])
    return np.asarray(1.0 / compliance[:, SUN, SUN], dtype=np.float64)
