"""References of the three phase currents from the setpoint of the quadrature current.

The drive's ampere is that of its trace, an rms value: a quadrature current i makes the torque Kt i with Kt = 1.91 N m/A
= 2 Ke. Sinusoidal phases of Ke = 0.955 V s/rad with the peak current i would make only 1.5 Ke i = 1.43 i, so the peak
must be Kt / (1.5 Ke) = 4/3 of the drive's ampere for the torque of the trace. Block-shaped currents, always carried by
two phases, make 2 Ke i: their factor is Kt / (2 Ke) = 1. (The thesis gives Ke as half of Kt, but no shape.)
"""

from ..compiled import compiled


@compiled
def phase_amplitude(winding):
    """Peak phase current [A] per ampere of quadrature current, with which a healthy motor's torque is Kt i."""
    phases = 2.0 if winding.trapezoidal != 0.0 else 1.5
    return winding.torque_constant / (phases * winding.back_emf_constant)


@compiled
def block(shape):
    """Share of the current that a phase carries in block commutation: all on its trapezoid's flats, otherwise none.

    The third phase's reference is zero and is held by its own leg: each phase has a comparator (``inverter.py``).
    """
    return shape if shape * shape == 1.0 else 0.0
