"""How strangers name their columns: in English, in German or by symbols, with units in any place and spelling."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

NAMES: dict[str, dict[str, Sequence[str]]] = {
    "english": {
        "time": ("time", "Time", "t", "timestamp", "elapsed time"),
        "motor_position": (
            *("motor position", "motor angle", "position", "angle", "pos", "MotorPos", "rotor angle"),
            *("actual position", "motor_pos", "encoder", "motor encoder", "shaft angle", "act_pos", "theta_motor"),
        ),
        "speed": (
            *("motor speed", "speed", "velocity", "vel", "ActualVelocity", "rotor speed", "motor_vel", "omega"),
            *("act_vel", "speed_actual", "shaft speed"),
        ),
        "speed_setpoint": (
            *("speed setpoint", "velocity reference", "speed_cmd", "vel_ref", "TargetVelocity", "demanded speed"),
            *("speed demand", "commanded velocity", "vel_sp"),
        ),
        "motor_torque": ("torque", "motor torque", "Torque actual", "shaft torque", "drive torque"),
        "current": ("current", "motor current", "iq", "i_q", "Iq actual", "q current", "cur", "MotorCurrent", "i_act"),
        "output_position": (
            *("output position", "load angle", "link angle", "joint position", "LoadPos", "arm angle"),
            *("output encoder", "load_pos", "gear output angle", "secondary encoder"),
        ),
    },
    "german": {
        "time": ("Zeit", "t", "Messzeit", "Zeitstempel"),
        "motor_position": (
            *("Lage", "Motorwinkel", "Motorlage", "Rotorlage", "Lageistwert", "Winkel", "Position Motor"),
            *("Motorgeber", "Rotorwinkel", "Istlage", "phi_Motor"),
        ),
        "speed": ("Drehzahl", "n_ist", "Motordrehzahl", "Istdrehzahl", "Winkelgeschwindigkeit", "Drehzahlistwert"),
        "speed_setpoint": ("n_soll", "Solldrehzahl", "Drehzahlsollwert", "Drehzahl Soll", "Sollwert Drehzahl"),
        "motor_torque": ("Drehmoment", "Moment", "M_ist", "Motormoment", "Momentenistwert"),
        "current": ("Strom", "Motorstrom", "i_ist", "Iststrom", "Strom q", "i_q_ist", "Stromistwert"),
        "output_position": (
            *("Abtriebswinkel", "Lastlage", "Lastwinkel", "Winkel Abtrieb", "Abtriebslage", "Lage Last"),
            *("Geber Abtrieb", "phi_Last", "Armwinkel"),
        ),
    },
    "symbols": {
        "time": ("t", "T", "time"),
        "motor_position": ("q_m", "phi_M", "theta1", "φ_m", "θ_1", "q1", "phi", "theta_m", "q", "φ", "ϕ1", "x_m"),
        "speed": ("dq_m", "omega_M", "w", "ω_m", "ω", "n", "phi_dot", "φ̇", "θ̇_m", "qd", "dtheta", "n_m", "dphi/dt"),
        "speed_setpoint": ("omega_ref", "w_set", "n*", "ω_ref", "n_ref", "ω_soll", "w_cmd", "omega_d"),
        "motor_torque": ("M", "tau", "τ", "tau_m", "T_m", "M_M", "M_el"),
        "current": ("i", "iq", "i_q", "I", "I_m", "i_M", "Iq", "i_mot"),
        "output_position": ("q_l", "phi_L", "theta2", "φ_L", "θ_2", "q2", "theta_l", "phi_out", "ϕ2", "q_L"),
    },
}
"""Names of each signal by language."""

UNITS: dict[str, dict[str, tuple[float, Sequence[str]]]] = {
    "time": {"s": (1.0, ("s", "sec", "Sek")), "ms": (1e-3, ("ms", "msec")), "us": (1e-6, ("us", "µs", "μs"))},
    "position": {
        "rad": (1.0, ("rad",)),
        "deg": (math.pi / 180.0, ("deg", "°", "Grad")),
        "rev": (2.0 * math.pi, ("rev", "turns", "U", "Umdr", "Umdrehungen")),
        "mrad": (1e-3, ("mrad",)),
    },
    "speed": {
        "rad/s": (1.0, ("rad/s", "rad s^-1", "1/s")),
        "rpm": (math.pi / 30.0, ("rpm", "1/min", "U/min", "min^-1", "RPM")),
        "deg/s": (math.pi / 180.0, ("deg/s", "°/s", "Grad/s")),
        "rev/s": (2.0 * math.pi, ("rev/s", "U/s", "rps")),
    },
    "torque": {"N m": (1.0, ("Nm", "N m", "N·m", "N*m")), "mN m": (1e-3, ("mNm", "mN m"))},
    "current": {"A": (1.0, ("A", "Amp", "Arms")), "mA": (1e-3, ("mA",))},
}
"""Of each quantity, units, the SI value of one, and how they are spelt."""

GERMAN_UNITS = frozenset({"Sek", "Grad", "U", "Umdr", "Umdrehungen", "U/min", "Grad/s", "U/s"})

BESIDE: dict[str, tuple[str, ...]] = {
    "Kommentar": ("", "ok", "", "Pause"),
    "status": ("RUN",),
    "mode": ("AUTO", "AUTO", ""),
    "T_winding [°C]": ("31.5",),
    "Udc [V]": ("48.1", "48.0"),
    "flags": ("0x1F",),
    "error": ("0",),
    "i_d [A]": ("0.01", "-0.02"),
    "temp": ("24.5", ""),
    "operator": ("Jürgen",),
    "sample": (),
}
"""Columns that nobody needs, and what stands in their cells; ``sample`` counts the rows."""

QUANTITY = {
    "time": "time",
    "motor_position": "position",
    "output_position": "position",
    "speed": "speed",
    "speed_setpoint": "speed",
    "motor_torque": "torque",
    "current": "current",
}


def named(signal: str, language: str, random: np.random.Generator) -> str:
    """A name of a signal; now and then in capitals, or with underscores for blanks."""
    name = str(random.choice(NAMES[language][signal]))
    style = random.integers(5)
    if style == 0:
        return name.replace(" ", "_")
    if style == 1 and language == "english" and len(name) > 2:
        return name.title()
    return name


def spelt(unit: str, quantity: str, language: str, random: np.random.Generator) -> str:
    """A spelling of a unit that goes with the language."""
    spellings = [text for text in UNITS[quantity][unit][1] if language == "german" or text not in GERMAN_UNITS]
    return str(random.choice(spellings))


def with_unit(name: str, spelling: str, place: str) -> str:
    """A column's name with its unit in brackets, after a slash, a comma or an underscore, or after a word."""
    if place == "_":
        return f"{name}_{spelling}" if re.fullmatch(r"[A-Za-z]+", spelling) else f"{name} [{spelling}]"
    forms = {"[]": "{} [{}]", "()": "{} ({})", "/": "{} / {}", "tight": "{}/{}", "in": "{} in {}", ",": "{}, {}"}
    return forms[place].format(name, spelling)
