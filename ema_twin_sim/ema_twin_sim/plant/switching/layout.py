"""The winding's constants and state as records, so that compiled code reads them by name."""

from __future__ import annotations

import numpy as np

WINDING = np.dtype(
    [
        # motor, healthy
        ("pole_pairs", "f8"),
        ("phase_resistance", "f8"),  # ohm per phase in star: half of what is measured phase to phase
        ("phase_inductance", "f8"),  # H per phase, minus the mutual one: half of what is measured phase to phase
        ("back_emf_constant", "f8"),  # V s/rad per phase, peak, over the motor's mechanical speed
        ("torque_constant", "f8"),  # N m/A of quadrature current, of the healthy motor: assumed by the drive
        ("trapezoidal", "f8"),  # 0 sinusoidal back-EMF and currents, 1 trapezoidal ones with block commutation
        ("torque_limit", "f8"),  # N m, limit of the motor's torque; infinite for none
        # motor, faults
        ("magnet_strength", "f8"),  # share of the healthy flux, 1 if healthy; unknown to the drive
        ("active_turns_u", "f8"),  # share of the phase's turns that is not shorted, 1 if healthy
        ("active_turns_v", "f8"),
        ("active_turns_w", "f8"),
        ("eccentricity", "f8"),  # displacement of the rotor axis relative to the air gap, 0 if centred
        ("eccentricity_phase", "f8"),  # rad
        # resolver
        ("resolver_offset", "f8"),  # rad of the motor shaft, lead
        ("resolver_amplitude", "f8"),  # rad of the motor shaft, of a periodic error
        ("resolver_order", "f8"),  # cycles of that error per motor turn
        ("resolver_phase", "f8"),  # rad
        # inverter
        ("dc_link_voltage", "f8"),  # V
        ("hysteresis", "f8"),  # A, half the band
        ("switch_resistance", "f8"),  # ohm of a conducting switch or diode
        # signal acquisition
        ("current_filter", "f8"),  # s, of the quadrature and direct currents and the quadrature voltage
    ],
    align=True,
)

WINDING_STATE = np.dtype(
    [
        ("phase_current_u", "f8"),  # A, into the winding
        ("phase_current_v", "f8"),
        ("phase_current_w", "f8"),
        ("leg_u", "f8"),  # 1 if the leg's upper switch conducts, -1 if the lower one does
        ("leg_v", "f8"),
        ("leg_w", "f8"),
        ("quadrature_current", "f8"),  # A of the drive's trace, filtered
        ("direct_current", "f8"),  # A of the drive's trace, filtered; negative weakens the magnets' flux
        ("quadrature_voltage", "f8"),  # V per phase, peak, filtered
    ],
    align=True,
)


def resting() -> np.ndarray:
    """State (1,) of a winding without current, with all lower switches closed."""
    state = np.zeros(1, WINDING_STATE)
    for leg in ("leg_u", "leg_v", "leg_w"):
        state[leg] = -1.0
    return state
