"""The constants of a switching drive: DC link, inverter, resolver, and the three windings with their faults.

Without fault parameters the motor is healthy. Sources and equations: ``plant/switching``.
"""

import math

from ..effects.effect import POSITIVE
from .constant import Constant


def _row(
    part: str, name: str, unit: str, lower: float, upper: float, description: str, usual: float | None = None
) -> Constant:
    return Constant(part, name, unit, lower, upper, description, kind="switching", usual=usual)


SWITCHING_CONSTANTS = (
    Constant("machine", "pole_pairs", "1", 1.0, 100.0, "pole pairs of the motor", kind="switching", everywhere=True),
    _row("machine", "active_turns_u", "1", 0.01, 1.0, "share of the turns of phase u that are not shorted", 1.0),
    _row("machine", "active_turns_v", "1", 0.01, 1.0, "share of the turns of phase v that are not shorted", 1.0),
    _row("machine", "active_turns_w", "1", 0.01, 1.0, "share of the turns of phase w that are not shorted", 1.0),
    _row("machine", "eccentricity", "1", 0.0, 0.99, "static eccentricity of the rotor over the air gap", 0.0),
    _row("machine", "eccentricity_phase", "rad", -6.284, 6.284, "its direction, at the motor counter's zero", 0.0),
    _row("drive", "dc_link_voltage", "V", POSITIVE, math.inf, "voltage of the DC link"),
    _row("drive", "hysteresis", "A", POSITIVE, math.inf, "half the band of the phase currents' hysteresis controllers"),
    _row("drive", "switch_resistance", "ohm", 0.0, math.inf, "resistance of a switch that conducts", 0.0),
    _row("drive", "current_filter", "s", 0.0, 1.0, "first-order filter of the current as the drive reports it"),
    _row("drive", "resolver_amplitude", "rad", 0.0, 1.0, "amplitude of the resolver's error, of the shaft", 0.0),
    _row("drive", "resolver_order", "1", 0.0, 1000.0, "cycles of that error per turn of the motor", 1.0),
    _row("drive", "resolver_phase", "rad", -6.284, 6.284, "phase of that error", 0.0),
    _row("drive", "resolver_offset", "rad", -3.15, 3.15, "constant part of the resolver's error, of the shaft", 0.0),
)

SWITCHING_CHOICES: dict[str, tuple[str, ...]] = {"machine.back_emf_shape": ("sinusoidal", "trapezoidal")}
