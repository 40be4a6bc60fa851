"""The constants of a machine, its drive, transmission and sensors: names, units, bounds, meaning.

A model file gives each one as ``{value, unit, tolerance, source}``; its unit must be the one in this table, or its
counterpart on a linear machine. Machines come in all sizes: quantities that scale with the machine (inertia, torque,
current) are bounded by sign only; shares, angles, and the times of drive and sensors have numeric bounds.
"""

from __future__ import annotations

from functools import partial
from math import inf

from ..effects.effect import POSITIVE
from .constant import Constant
from .planetary_constants import PLANETARY_CHOICES, PLANETARY_CONSTANTS
from .switching_constants import SWITCHING_CHOICES, SWITCHING_CONSTANTS

__all__ = ["CHOICES", "CONSTANTS", "KINDS", "PARTS", "Constant"]

PARTS: tuple[str, ...] = ("machine", "drive", "transmission", "sensors")

_machine, _drive, _transmission, _sensors = (partial(Constant, part) for part in PARTS)

_ALWAYS = (
    _machine("gear_ratio", "1", 1e-3, 1e5, "fast shaft turns per slow shaft turn", absent=1.0),
    _machine("motor_inertia", "kg m^2", POSITIVE, inf, "inertia of the motor"),
    _machine("gearbox_inertia", "kg m^2", 0.0, inf, "inertia of the gearbox at the fast shaft", absent=0.0),
    _machine("output_inertia", "kg m^2", 0.0, inf, "inertia of the user at the fast shaft", absent=0.0),
    _machine("torque_constant", "N m/A", POSITIVE, inf, "torque per ampere of quadrature current", absent=1.0),
    _machine("back_emf_constant", "V s/rad", 0.0, inf, "quadrature back-EMF per phase and speed", absent=0.0),
    _machine("phase_resistance", "ohm", 0.0, inf, "winding resistance of one phase", absent=0.0),
    _machine("phase_inductance", "H", 0.0, inf, "winding inductance of one phase", absent=0.0),
    _drive("position_gain", "1/s", 0.0, inf, "speed setpoint (fast) per position error (slow)", absent=0.0),
    _drive("speed_limit", "rad/s", POSITIVE, inf, "limit of the speed setpoint, fast shaft", absent=1e5),
    _drive("speed_setpoint_filter", "s", 0.0, 1.0, "first-order lag of the speed setpoint", absent=0.0),
    _drive("speed_gain", "N m s/rad", 0.0, inf, "proportional gain of the speed controller", absent=0.0),
    _drive("integral_time", "s", 1e-5, 1e3, "integral time of the speed controller", absent=1e3),
    _drive("integral_limit", "N m", 0.0, inf, "limit of the speed controller's integrator", absent=0.0),
    _drive(
        "integral_dead_band", "rad", 0.0, 10.0, "position error (fast) within which the integrator holds", absent=0.0
    ),
    _drive("anti_windup_time", "s", 1e-5, 1e3, "back-calculation time of the anti-windup", absent=1e3),
    _drive("torque_limit", "N m", POSITIVE, inf, "limit of the torque setpoint", absent=1e6),
    _drive("current_limit", "A", POSITIVE, inf, "limit of the current setpoint", absent=1e5),
    _drive("control_cycle", "s", 1e-5, 0.1, "period of the speed controller", absent=1.25e-4),
    _drive("current_lag", "s", 0.0, 0.1, "first-order lag of the current behind its setpoint", absent=0.0),
    _transmission("contact_stiffness", "N m/rad", POSITIVE, inf, "contact stiffness at the fast shaft", absent=1e4),
    _transmission("contact_damping", "N m s/rad", 0.0, inf, "contact damping at the fast shaft", absent=1.0),
    _transmission("end_stop_lower", "rad", -1e9, 0.0, "lower end stop, slow shaft", optional=True),
    _transmission("end_stop_upper", "rad", 0.0, 1e9, "upper end stop, slow shaft", optional=True),
    _sensors("motor_encoder_counts", "1/rev", 1.0, 1e12, "motor counter, per turn of the fast shaft", absent=1e12),
    _sensors("output_encoder_counts", "1/rev", 1.0, 1e12, "output encoder, per turn of the slow shaft", absent=1e12),
    _sensors("speed_smoothing", "s", 0.0, 1.0, "first-order smoothing of the reported speed", absent=0.0),
    _sensors("sample_period", "s", 1e-5, 1.0, "period of the drive's trace", absent=1e-3),
    _sensors("current_noise", "A", 0.0, inf, "white noise of the current, standard deviation", absent=0.0),
    _sensors("speed_noise", "rad/s", 0.0, inf, "white noise of the speed, standard deviation", absent=0.0),
    _sensors("motor_encoder_noise", "count", 0.0, 1e6, "white noise of the motor counter", absent=0.0),
    _sensors("output_encoder_noise", "count", 0.0, 1e6, "white noise of the output encoder", absent=0.0),
)
"""Those of every machine, whatever its fidelity."""

CONSTANTS: dict[str, Constant] = {
    constant.path: constant for constant in (*_ALWAYS, *SWITCHING_CONSTANTS, *PLANETARY_CONSTANTS)
}

KINDS: dict[str, tuple[str, ...]] = {
    "drive": ("averaged", "switching"),
    "transmission": ("rigid", "two_inertia", "planetary"),
}
"""The possible fidelities of each part."""

CHOICES: dict[str, dict[str, tuple[str, ...]]] = {"switching": SWITCHING_CHOICES, "planetary": PLANETARY_CHOICES}
"""By fidelity and path, the choices of a model; the first is the default."""
