"""Angles among a unit's numbers: the phase of a wave, the direction of an arm."""

from __future__ import annotations

import math
import re

import numpy as np

from ..criteria import SIGNIFICANT
from ..effects import catalogue


def is_angle(path: str) -> bool:
    """Whether a number (``sun_runout.phase``) is an effect's periodic angle; the owner's name may end in a number."""
    owner, _, name = like_path(path).rpartition(".")
    effect = catalogue().get(owner)
    return effect is not None and any(p.name == name and p.periodic for p in effect.parameters)


def like_path(path: str) -> str:
    """A number's path without the count of its effect: ``coulomb_friction.torque`` of ``coulomb_friction_2.torque``."""
    return re.sub(r"_\d+(?=\.[^.]*$)", "", path)


def within_half_a_turn(angles: np.ndarray) -> np.ndarray:
    """Angles [rad] brought to -π to π by whole turns."""
    return np.remainder(angles + math.pi, 2.0 * math.pi) - math.pi


def is_known(standard_error: float) -> bool:
    """Whether an angle with this standard error [rad] is known: its wave's amplitude is significant."""
    return standard_error * SIGNIFICANT < 1.0
