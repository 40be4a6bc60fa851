"""Three windings in star with a floating star point.

Phase k, from its leg's voltage v_k (to the middle of the DC link): v_k - v_n = R_k i_k + L_k di_k/dt + e_k, and the
currents add up to zero, which determines the star point's voltage v_n, also if the phases are unequal. Currents are
integrated with the implicit midpoint rule: every term uses the mean current m of the step, and e_k the angle of its
middle. This is second order, stable at any step, and conserves energy exactly: multiplied by m_k and summed,

    sum v_k m_k = sum R_k m_k^2 + sum L_k (i_k'^2 - i_k^2) / (2 h) + sum e_k m_k,

where v_n vanishes because the m_k add up to zero. Solved for the step's end, with g_k = 1 / (L_k / h + R_k / 2) and
f_k = v_k - e_k - R_k i_k: i_k' - i_k = g_k (f_k - v_n), v_n = sum g_k f_k / sum g_k; in the two voltages f_u - f_w
and f_v - f_w that is a symmetric matrix of three constants (``step_constants.py``).

Shorted turns leave a share N of a phase's turns (the script's BLDC.Nabc): N of the back-EMF (turns that the flux cuts),
N of the resistance (length of wire), N^2 of the inductance. The current in the shorted loop, its heat and its braking
torque are not modelled. Shorts and eccentricity are the faults of the bench's group (Dalla Vedova, Germanà, Berri and
Maggiore, Aerospace 6, 2019, 94).

Eccentricity: a rotor off centre by the share zeta of the air gap leaves a relative gap 1 - zeta cos around the stator,
and the flux is its inverse, to first order 1 + zeta cos. The script gives a modulus and a phase (BLDC.zeta, BLDC.phi);
its block is not printed. Here each phase meets the narrow gap when the rotor has turned to it, a third of a turn after
the previous one: k_k = Ke N_k (1 + zeta cos(theta + phi - 2 pi k / 3)), k = 0, 1, 2. One cosine common to all three
would modulate the whole flux, which no displacement does: it widens the gap on one side as it narrows it on the other.
(A gap that stayed narrow at one place of the stator would only make the phases unequal, as active turns do.) With
imposed sinusoidal currents the torque keeps its mean and has a ripple of zeta / 2 at the order P + P + 1 (see the
tests).
"""

import math

from ..compiled import compiled
from .electrical_angle import sine_and_cosine
from .shapes import three_phases


@compiled
def eccentric(constants, angle):
    """Factors on the three phases' back-EMF at a motor angle [rad] for an eccentric rotor."""
    sine, cosine = sine_and_cosine((angle + constants.eccentricity_phase) / (2.0 * math.pi))
    u, v, w = three_phases(cosine, -sine)  # shifted by a quarter turn: cosines
    return (
        1.0 + constants.eccentricity * u,
        1.0 + constants.eccentricity * v,
        1.0 + constants.eccentricity * w,
    )


@compiled
def current_changes(constants, current_u, current_v, voltage_u, voltage_v, voltage_w):
    """Changes [A] of the currents of u and v in a step, from currents [A] and voltages minus the back-EMF [V]."""
    free_w = voltage_w + constants.resistance_w * (current_u + current_v)
    across_u = voltage_u - constants.resistance_u * current_u - free_w
    across_v = voltage_v - constants.resistance_v * current_v - free_w
    return (
        constants.response_uu * across_u + constants.response_uv * across_v,
        constants.response_uv * across_u + constants.response_vv * across_v,
    )
