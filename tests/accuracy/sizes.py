"""How large an effect is: the usual sizes, drawn per effect, and what a size multiplies."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .hide import CATALOGUE, UNKNOWN
from .machine import Machine
from .other_bench import Cause


@dataclass(frozen=True)
class Usual:
    """The usual range of a parameter: drawn evenly in the logarithm, with either sign where ``signed``."""

    low: float
    high: float
    signed: bool = False
    zero: float = 0.0  # the value at which the effect does nothing, which sizes are counted from

    def draw(self, random: np.random.Generator) -> float:
        """A value of the range."""
        sign = float(random.choice([-1.0, 1.0])) if self.signed else 1.0
        return self.zero + sign * math.exp(random.uniform(math.log(self.low), math.log(self.high)))

    @property
    def middle(self) -> float:
        """The size in the middle of the range."""
        return math.sqrt(self.low * self.high)


@dataclass(frozen=True)
class Angle:
    """Any angle."""

    def draw(self, random: np.random.Generator) -> float:
        """An angle [rad] from 0 on."""
        return float(random.uniform(0.0, 2.0 * math.pi))


# The first parameter is the effect's size: what `small` cases and the sweep multiply.
_USUAL: Mapping[str, Mapping[str, Usual | Angle]] = {
    "viscous_friction": {},
    "coulomb_friction": {},
    "stribeck_friction": {"torque": Usual(0.04, 0.1), "speed": Usual(0.6, 2.5)},
    "smooth_friction": {"speed": Usual(0.6, 2.5)},
    "asymmetric_friction": {"fraction": Usual(0.1, 0.3, signed=True)},
    "presliding_friction": {"stiffness": Usual(0.7, 4.0), "damping": Usual(0.003, 0.02)},
    "quadratic_drag": {"coefficient": Usual(3e-4, 1.2e-3)},
    "shear_thinning": {"fraction": Usual(0.25, 0.6), "speed": Usual(2.0, 12.0)},
    "thermal_friction": {"fraction": Usual(0.15, 0.35), "time_constant": Usual(5.0, 15.0)},
    "mesh_friction": {"coefficient": Usual(0.12, 0.3)},
    "sun_runout": {"torque": Usual(0.012, 0.04), "phase": Angle()},
    "mesh_ripple": {"torque": Usual(0.01, 0.03), "phase": Angle()},
    "tooth_fault": {"torque": Usual(0.03, 0.09), "position": Angle()},
    "cogging": {"torque": Usual(0.015, 0.05), "phase": Angle()},
    "torque_ripple": {"fraction": Usual(0.04, 0.1), "phase": Angle()},
    "current_offset": {"torque": Usual(0.01, 0.03), "phase": Angle()},
    "phase_short": {"fraction": Usual(0.12, 0.3)},
    "rotor_eccentricity": {"amplitude": Usual(0.08, 0.2), "phase": Angle()},
    # off by more than constants that are known to 5 % can hide
    "torque_constant_error": {"scale": Usual(0.13, 0.22, signed=True, zero=1.0)},
    "added_inertia": {"inertia": Usual(4.5e-4, 1.2e-3)},
    "constant_load": {"torque": Usual(0.02, 0.06, signed=True)},
    "gravity_load": {"torque": Usual(0.04, 0.1), "angle": Angle()},
    "spring_load": {"stiffness": Usual(0.04, 0.15)},
    "backlash": {"width": Usual(0.0015, 0.006)},
    # softer, and the drive runs away with it: nobody would record that
    "shaft_compliance": {"stiffness": Usual(9.0, 25.0), "damping": Usual(0.008, 0.03)},
    "encoder_delay": {"delay": Usual(0.002, 0.008)},
    "encoder_eccentricity": {"amplitude": Usual(3e-4, 1e-3), "phase": Angle()},
    # in no catalogue
    "bursts": {"torque": Usual(0.05, 0.1), "spacing": Usual(1.0, 2.5)},
    "output_friction": {"torque": Usual(0.015, 0.035), "phase": Angle()},
    "odd_order": {"torque": Usual(0.012, 0.03), "phase": Angle()},
    "friction_resonance": {"torque": Usual(0.04, 0.08), "speed": Usual(3.5, 7.0), "width": Usual(0.5, 1.0)},
    "moods": {"fraction": Usual(0.25, 0.45)},
}
_OPTIONS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "sun_runout": {"kind": ("dissipative", "conservative")},
    "mesh_ripple": {"order": ("15.75", "15.75", "15.0", "45")},
    "tooth_fault": {"order": ("1", "2.25", "0.75", "0.7258"), "kind": ("dissipative", "conservative")},
    "cogging": {"order": ("24", "24", "24", "12", "36")},
    "phase_short": {"phase": ("u", "v", "w")},
    "output_friction": {"order": ("14.2", "19.7", "26.3", "33.1", "43.6")},  # of the slow shaft
    "odd_order": {"order": ("5.3", "7.3", "9.4", "11.2", "20.6")},
}

OF_THE_STOCK_MODEL = ("viscous_friction", "coulomb_friction")
"""Effects that the stock model holds already: hidden whole, by taking them out of it, or not at all."""
_INVERSE = ("presliding_friction", "shaft_compliance")
"""Effects whose size is a stiffness: the stiffer, the smaller the effect."""

assert tuple(_USUAL) == (*CATALOGUE, *UNKNOWN)


SIZE_OF: Mapping[str, tuple[str, Usual]] = {
    id: (name, usual)
    for id, parameters in _USUAL.items()
    for name, usual in itertools.islice(parameters.items(), 1)
    if isinstance(usual, Usual)
}
"""Of each effect that has a size: the parameter that is it, and its usual range."""


def drawn_causes(ids: Sequence[str], machine: Machine, random: np.random.Generator, size: float = 1.0) -> list[Cause]:
    """Causes of usual size times ``size``, quiet together."""
    whole = {
        "viscous_friction": {"coefficient": machine.motor_viscous + machine.output_viscous},
        "coulomb_friction": {"torque": machine.motor_level + machine.output_level},
    }
    drawn = [_drawn(id, random) for id in ids]
    causes = [_resized(replace(cause, values=whole.get(cause.id, cause.values)), size) for cause in drawn]
    if {"backlash", "shaft_compliance"} <= set(ids):
        # a gap before a spring without much damping swings by itself at an ampere, which nobody would record
        tamed = {
            "backlash": {"width": size * Usual(0.001, 0.003).draw(random)},
            "shaft_compliance": {"damping": Usual(0.15, 0.3).draw(random)},
        }
        causes = [replace(cause, values={**cause.values, **tamed.get(cause.id, {})}) for cause in causes]
    return causes


def middling_cause(id: str, random: np.random.Generator, size: float) -> Cause:
    """A cause exactly ``size`` times as large as the middle of its usual range; all else drawn."""
    name, usual = SIZE_OF[id]
    cause = _drawn(id, random)
    sign = -1.0 if cause.values[name] < usual.zero else 1.0
    return _resized(replace(cause, values={**cause.values, name: usual.zero + sign * usual.middle}), size)


def _drawn(id: str, random: np.random.Generator) -> Cause:
    values = {name: usual.draw(random) for name, usual in _USUAL[id].items()}
    return Cause(id, values, {name: str(random.choice(choices)) for name, choices in _OPTIONS.get(id, {}).items()})


def _resized(cause: Cause, size: float) -> Cause:
    if cause.id not in SIZE_OF or size == 1.0:
        return cause
    name, usual = SIZE_OF[cause.id]
    away = cause.values[name] - usual.zero
    changed = away / size if cause.id in _INVERSE else away * size
    return replace(cause, values={**cause.values, name: usual.zero + changed})
