"""The signals of a recording, their units on rotary and linear machines, and conversion factors to SI."""

from __future__ import annotations

import math
import re
from typing import Any

MOTIONS: tuple[str, ...] = ("rotary", "linear")
"""Kinds of motion: rotary (rad, rad/s, N m, kg m²) and linear (m, m/s, N, kg)."""

_POSITION = {"rad": 1.0, "deg": math.pi / 180.0, "rev": 2.0 * math.pi, "mrad": 1e-3, "mdeg": 1e-3 * math.pi / 180.0,
             "arcmin": math.pi / 10800.0, "arcsec": math.pi / 648000.0}  # fmt: skip
_SPEED = {"rad/s": 1.0, "deg/s": math.pi / 180.0, "rpm": 2.0 * math.pi / 60.0, "rev/s": 2.0 * math.pi, "mrad/s": 1e-3,
          "mdeg/s": 1e-3 * math.pi / 180.0, "krpm": 2000.0 * math.pi / 60.0}  # fmt: skip
_INCH, _FOOT, _POUND, _KILOGRAM = 0.0254, 0.3048, 4.4482216152605, 9.80665
"""m, m, and N (the weight of a pound and a kilogram): exact by definition."""
_TORQUE = {"N m": 1.0, "mN m": 1e-3, "uN m": 1e-6, "N cm": 1e-2, "N mm": 1e-3, "kN m": 1e3, "lbf in": _POUND * _INCH,
           "lbf ft": _POUND * _FOOT, "ozf in": _POUND / 16.0 * _INCH, "kgf m": _KILOGRAM,
           "kgf cm": 1e-2 * _KILOGRAM, "gf cm": 1e-5 * _KILOGRAM}  # fmt: skip
_LENGTH = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "in": _INCH, "ft": _FOOT}
_VELOCITY = {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "m/min": 1.0 / 60.0, "in/s": _INCH, "in/min": _INCH / 60.0,
             "ft/s": _FOOT, "ft/min": _FOOT / 60.0}  # fmt: skip
_FORCE = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": _POUND, "ozf": _POUND / 16.0, "kip": 1e3 * _POUND,
          "kgf": _KILOGRAM, "gf": 1e-3 * _KILOGRAM}  # fmt: skip
_CURRENT = {"A": 1.0, "mA": 1e-3, "uA": 1e-6}
_VOLTAGE = {"V": 1.0, "mV": 1e-3}
_TEMPERATURE = {"degC": 1.0}

_QUANTITIES: dict[str, tuple[dict[str, float], dict[str, float]]] = {
    "position": (_POSITION, _LENGTH),
    "speed": (_SPEED, _VELOCITY),
    "torque": (_TORQUE, _FORCE),
    "current": (_CURRENT, _CURRENT),
    "voltage": (_VOLTAGE, _VOLTAGE),
    "temperature": (_TEMPERATURE, _TEMPERATURE),
}
"""For each quantity (rotary, linear): SI value of each unit. The first unit is the one used in recordings."""

QUANTITY_OF: dict[str, str] = {
    "current": "current",  # quadrature
    "current_setpoint": "current",
    "speed": "speed",  # fast shaft
    "speed_setpoint": "speed",  # fast shaft
    "motor_position": "position",  # fast shaft, unwrapped
    "output_position": "position",  # slow shaft
    "output_command": "position",  # slow shaft
    "voltage": "voltage",  # quadrature
    "motor_torque": "torque",
    "load_torque": "torque",  # fast shaft
    "temperature": "temperature",
    "direct_current": "current",
    "phase_current_u": "current",
    "phase_current_v": "current",
    "phase_current_w": "current",
    "unexplained_torque": "torque",  # fast shaft; only a twin fills it
}
"""The signals that a recording may hold, and the quantity that each measures: the only list of them in Python. They are
the float64 fields of `ema_twin_msgs/EmaState`."""

SIGNALS: tuple[str, ...] = tuple(QUANTITY_OF)

ALL_UNITS: dict[str, float] = {
    unit: value for kinds in _QUANTITIES.values() for kind in kinds for unit, value in kind.items()
}
"""SI value of each unit."""

_LINEAR = {
    "rad": "m",
    "rad/s": "m/s",
    "rad/s^2": "m/s^2",
    "N m": "N",
    "N m/A": "N/A",
    "N m/rad": "N/m",
    "N m s/rad": "N s/m",
    "N m s^2/rad^2": "N s^2/m^2",
    "kg m^2": "kg",
    "V s/rad": "V s/m",
    "1/rev": "1/m",
}
"""Linear counterpart of each rotary unit; other units are the same for both."""


def units_of(signal: str, motion: str = "rotary") -> dict[str, float]:
    """The units in which a signal may be given, with their SI values."""
    return _QUANTITIES[QUANTITY_OF[signal]][MOTIONS.index(motion)]


def signal_unit(signal: str, motion: str = "rotary") -> str:
    """The unit of a signal in recordings."""
    return next(iter(units_of(signal, motion)))


def usual_spelling(unit: Any) -> Any:
    """A unit with its powers as they are written here: rad/s^2 for rad/s2 and rad/s², too. What is no text stays."""
    return re.sub(r"(?<=[A-Za-z])(?:\^?2|²)", "^2", unit) if isinstance(unit, str) else unit


def unit_in(unit: str, motion: str) -> str:
    """The counterpart of a rotary unit (``N m s/rad``) for that kind of motion (``N s/m``)."""
    return _LINEAR.get(unit, unit) if motion == "linear" else unit
