"""Mesh stiffness (thesis, section 3.8): Kuang and Yang's teeth, constant, or a short Fourier series.

All in N/m along the line of action. Eq. 3.48 is for steel; for other materials it is scaled by Young's modulus relative
to steel (the bench's gearbox is printed plastic). The face width is multiplied once; the script's constant form does it
twice.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .contact import Mesh, Position
from .geometry import Gearing

PRINTED_HARMONICS = (1, 3, 5)
MOST_TEETH = 100  # eq. 3.48 is given for 12 to 100 teeth

Array = NDArray[np.float64]


def tooth_stiffness(teeth: int, height: Position, profile_shift: float = 0.0) -> Position:
    """Stiffness of one steel tooth per metre of face width [N/m^2] (eq. 3.48; Kuang and Yang, 1992).

    ``height`` is that of the contact above the pitch circle, (r_i - R_i)/((1 + x) m); the thesis prints x_i for r_i.
    From 12 to 100 teeth. A wheel with more counts as one with 100: its teeth are nearly those of a rack, and the
    formula's cubics diverge.
    """
    z = min(teeth, MOST_TEETH)
    a0 = 3.867 + 1.612 * z - 0.02916 * z**2 + 0.0001553 * z**3
    a1 = 17.060 + 0.7289 * z - 0.01728 * z**2 + 0.00009993 * z**3
    a2 = 2.637 - 1.222 * z + 0.02217 * z**2 - 0.0001179 * z**3
    a3 = -6.330 - 1.033 * z + 0.02068 * z**2 - 0.0001130 * z**3
    return 1e9 * ((a0 + a1 * profile_shift) + (a2 + a3 * profile_shift) * height)


def pair_stiffness(gearing: Gearing, mesh: Mesh, position: Array, youngs_modulus_ratio: float = 1.0) -> Array:
    """Stiffness [N/m] of one pair of teeth in contact at ``position`` [m] from first contact (eqs 3.49 to 3.51).

    Two teeth in series, over the face width. The script divides two vectors by ``/``, a least-squares scalar; the
    elementwise quotient is meant. A ring's tooth counts as that of an external wheel with the same number of teeth,
    with its height measured inwards from the pitch circle: the formula does not cover internal teeth, which are
    somewhat thicker at the root.
    """
    first, second = mesh.curvature_radii(position)
    height = (1.0 + gearing.profile_shift) * gearing.module
    above_first = (np.hypot(mesh.first_base_radius, first) - mesh.first_pitch_radius) / height
    above_second = mesh.side * (np.hypot(mesh.second_base_radius, second) - mesh.second_pitch_radius) / height
    k1 = tooth_stiffness(mesh.first_teeth, above_first, gearing.profile_shift)
    k2 = tooth_stiffness(mesh.second_teeth, above_second, gearing.profile_shift)
    return youngs_modulus_ratio * gearing.face_width * k1 * k2 / (k1 + k2)


def single_pair_stiffness(gearing: Gearing, mesh: Mesh, youngs_modulus_ratio: float = 1.0) -> float:
    """Mean stiffness [N/m] of a pair that carries alone: k_c b of eqs 3.61 and 3.62, as in the script."""
    position = np.linspace(mesh.contact_length - mesh.base_pitch, mesh.base_pitch, 201)
    return float(np.mean(pair_stiffness(gearing, mesh, position, youngs_modulus_ratio)))


def constant_stiffness(gearing: Gearing, mesh: Mesh, youngs_modulus_ratio: float = 1.0) -> float:
    """Constant stiffness [N/m] of a mesh over its cycle: (0.75 e + 0.25) k_c b (eqs 3.61 and 3.62).

    e is the mesh's own contact ratio; the script uses 1.2 for all, and the sun mesh's stiffness for the ring, too.
    """
    share = 0.75 * mesh.contact_ratio + 0.25
    return share * single_pair_stiffness(gearing, mesh, youngs_modulus_ratio)


def printed_series(constant: float, cycle: Array) -> Array:
    """Mesh stiffness [N/m] over ``cycle`` (0 to 1) as eqs 3.55 to 3.60 print it: K + K/pi sum of sin(2 pi k x)/k.

    k is 1, 3 and 5, K the ``constant`` stiffness: the first terms of a square wave of 3/4 and 5/4 of K with equal
    halves, whereas two pairs are in contact for e - 1 of a cycle (a sixth on the bench).
    """
    k = np.array(PRINTED_HARMONICS)
    waves = np.sin(2.0 * math.pi * np.multiply.outer(cycle, k)) @ (1.0 / k)
    return constant * (1.0 + waves / math.pi)


def harmonics(cycle_of_values: Array, count: int) -> NDArray[np.complex128]:
    """Complex amplitudes of harmonics 1 to ``count`` of equally spaced values over one cycle (without its end point).

    The values are mean + sum of Re(amplitude_k exp(2 pi i k x)): the full form of the series truncated in eq. 3.55.
    """
    spectrum = np.fft.rfft(cycle_of_values) / len(cycle_of_values)
    return 2.0 * spectrum[1 : count + 1]
