"""The winding's constants and state as records, so that compiled code reads them by name."""

from __future__ import annotations

import numpy as np

WINDING = np.dtype(
    [
        # motor, healthy
        ("pole_pairs", "f8"),
        ("phase_resistance", "f8"),  # ohm per phase in star: half of what is measured phase to phase
        ("phase_inductance", "f8"),  # H per phase, less the mutual one: half of what is measured phase to phase
        ("back_emf_constant", "f8"),  # V s/rad per phase, peak, over the motor's mechanical speed
        ("torque_constant", "f8"),  # N m/A of quadrature current, of the healthy motor: what the drive believes
        ("trapezoidal", "f8"),  # 0 sinusoidal back-EMF and currents, 1 trapezoidal ones with block commutation
        ("torque_limit", "f8"),  # N m, where the motor's torque saturates; infinite for none
        # motor, what may have gone wrong with it
        ("magnet_strength", "f8"),  # share of the healthy flux, 1 for none lost; the drive does not know of it
        ("active_turns_u", "f8"),  # share of the phase's turns that is not shorted, 1 for all of them
        ("active_turns_v", "f8"),
        ("active_turns_w", "f8"),
        ("eccentricity", "f8"),  # displacement of the rotor's axis over the air gap, 0 for a centred one
        ("eccentricity_phase", "f8"),  # rad
        # resolver
        ("resolver_offset", "f8"),  # rad of the motor shaft by which it leads
        ("resolver_amplitude", "f8"),  # rad of the motor shaft, of an error that repeats
        ("resolver_order", "f8"),  # cycles of that error in a turn of the motor
        ("resolver_phase", "f8"),  # rad
        # inverter
        ("dc_link_voltage", "f8"),  # V
        ("hysteresis", "f8"),  # A, half the band
        ("switch_resistance", "f8"),  # ohm of a switch or diode that conducts
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
        ("leg_u", "f8"),  # 1 where the leg's upper switch conducts, -1 where its lower one does
        ("leg_v", "f8"),
        ("leg_w", "f8"),
        ("quadrature_current", "f8"),  # A of the drive's trace, filtered
        ("direct_current", "f8"),  # A of the drive's trace, filtered; negative weakens the magnets' flux
        ("quadrature_voltage", "f8"),  # V per phase, peak, filtered
    ],
    align=True,
)


def resting() -> np.ndarray:
    """State (1,) of a winding without current, all lower switches closed."""
    state = np.zeros(1, WINDING_STATE)
    for leg in ("leg_u", "leg_v", "leg_w"):
        state[leg] = -1.0
    return state
