"""Phase of each mesh in its cycle (thesis, section 3.9): one cycle is the passing of one tooth.

A cycle begins with the first contact of a pair of teeth, on the flanks in contact while the first wheel of the mesh
drives the second (positive mesh force, ``contact.py``). Phases are in cycles, from 0 to 1. Planets are numbered in the
positive direction of rotation, 120 degrees apart.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .geometry import OUTPUT_MESH, PLANETS, RING_MESH, SUN_MESH, Gearing

TURN = 2.0 * math.pi


def mesh_phases(gearing: Gearing) -> NDArray[np.float64]:
    """Phases (3 meshes, 3 planets) at zero angles; the first planet's sun mesh and output mesh are at their start.

    From planet to planet by eqs 3.52 and 3.53. The second is printed with z_s z_r, but z_s + z_r is meant (psi_n = 2 pi
    p_n/(z_s + z_r), p_n an integer; for equally spaced planets p_n = n (z_s + z_r)/3; the script's 32, 63 and 95 of 84
    are not equally spaced), and the script multiplies the cycles by pi/180. Between sun and ring meshes by
    ``sun_to_ring``. The phase between a planet's two toothings is a choice of the manufacturer, assumed to be zero.
    """
    planet = np.arange(PLANETS)
    phases = np.empty((PLANETS, PLANETS))
    phases[SUN_MESH] = -_thirds(planet, gearing.sun_teeth)  # a later planet meets the sun's earlier teeth
    phases[RING_MESH] = sun_to_ring(gearing) + _thirds(planet, gearing.ring_teeth)
    phases[OUTPUT_MESH] = _thirds(planet, gearing.output_ring_teeth)
    return phases % 1.0


def _thirds(planet: NDArray[np.int64], teeth: int) -> NDArray[np.float64]:
    """Cycles from the first planet to each, for a wheel: whole thirds, so that in-phase meshes are exactly in phase."""
    return planet * teeth % PLANETS / PLANETS


def sun_to_ring(gearing: Gearing) -> float:
    """Phase of a planet's ring mesh while its sun mesh is at its start (eq. 3.54, after Parker), 0 to 1.

    Sun and ring touch opposite flanks of the planet on opposite sides. While one is at its pitch point, the other is
    half the planet's teeth and half a tooth farther on: at its own pitch point for an odd number of teeth, half a cycle
    off for an even one. Teeth are as thick as their gaps.
    """
    sun, ring, _ = (mesh.approach / mesh.base_pitch for mesh in gearing.meshes)
    return (ring - sun + 0.5 * (gearing.planet_teeth + 1)) % 1.0


def opposite_flank(gearing: Gearing) -> NDArray[np.float64]:
    """Cycles c (one for each kind of mesh) such that a mesh at x is at c - x on its opposite flanks, without backlash.

    Opposite flanks carry a negative mesh force, as at the output ring of the bench driven by its motor. They touch on
    the mirrored line of action, pass it in reverse, and are half a cycle from the pitch point when the others are at
    it.
    """
    return np.array([(2.0 * mesh.approach / mesh.base_pitch + 0.5) % 1.0 for mesh in gearing.meshes])


def mesh_cycles(gearing: Gearing, sun: float, carrier: float, output: float) -> NDArray[np.float64]:
    """Cycles passed (3 meshes, 3 planets; not wrapped) at the angles [rad] of sun, carrier and output ring.

    The thesis uses time at constant speed; here they follow the angles.
    """
    turned = np.array(
        [
            gearing.sun_teeth * (sun - carrier),
            gearing.ring_teeth * carrier,
            gearing.output_ring_teeth * (carrier - output),
        ]
    )
    return mesh_phases(gearing) + turned[:, np.newaxis] / TURN
