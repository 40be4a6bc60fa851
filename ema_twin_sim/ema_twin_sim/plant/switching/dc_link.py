"""Limits of the DC link: the voltage needed for a speed and a current, and the highest speed at a current.

The bridge applies at most the DC link voltage across two phases. Sinusoidal phases: the amplitude of the phase voltage
(back-EMF and resistive drop in phase, the reactive drop in quadrature), times the root of three. Trapezoidal phases:
two in series between commutations; commutation itself needs some more voltage. Motor and bridge as in ``windings.py``,
healthy except for the magnets; steady state, without switching ripple.
"""

import math

import numpy as np

from .current_reference import phase_amplitude


def _phase(winding: np.void, current: float) -> tuple[float, float, float]:
    """(V s/rad of back-EMF, V across the resistance, V s/rad across the inductance) of a phase, peak values."""
    peak = phase_amplitude(winding) * abs(current)
    return (
        float(winding["back_emf_constant"] * winding["magnet_strength"]),
        float((winding["phase_resistance"] + winding["switch_resistance"]) * peak),
        float(winding["pole_pairs"] * winding["phase_inductance"] * peak),
    )


def voltage_needed(winding: np.void, speed: float, current: float) -> float:
    """DC link voltage [V] with which a motor at ``speed`` [rad/s] can carry ``current`` [A, quadrature], motoring."""
    emf, resistive, reactive = _phase(winding, current)
    if winding["trapezoidal"]:
        return 2.0 * (emf * abs(speed) + resistive)
    return math.sqrt(3.0) * math.hypot(emf * abs(speed) + resistive, reactive * speed)


def highest_speed(winding: np.void, current: float) -> float:
    """Highest speed [rad/s] at which the DC link can drive ``current`` [A, quadrature]; zero if it never can."""
    emf, resistive, reactive = _phase(winding, current)
    link = float(winding["dc_link_voltage"])
    if winding["trapezoidal"]:
        return max(0.0, (0.5 * link - resistive) / emf)
    # the positive root of (emf w + resistive)^2 + (reactive w)^2 = link^2 / 3
    spare = link * link / 3.0 - resistive * resistive
    if spare <= 0.0:
        return 0.0
    across = emf * resistive
    return spare / (across + math.sqrt(across * across + (emf * emf + reactive * reactive) * spare))
