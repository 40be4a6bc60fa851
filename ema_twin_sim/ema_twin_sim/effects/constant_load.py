"""Constant load: T = torque [N m], on the output side, at the fast shaft; positive opposes positive motion.

While sliding, a Coulomb level that differs by direction is the same, and is reported under this name.
"""

import math

from .effect import OUTPUT_TORQUE, Effect, Parameter, Trait


def act(at, p):
    """Torque [N m]."""
    return p[0]


EFFECT = Effect(
    id="constant_load",
    summary="a constant torque on the output: a weight on a drum, a preload",
    equation="T = torque",
    depends_on="direction",
    signature="current error that is the same in both directions, at every speed and position",
    shown_by="motion in both directions",
    source="statics",
    parameters=(Parameter("torque", "N m", 0.03, -math.inf, math.inf, "torque, reduced to the fast shaft"),),
    act=act,
    place=OUTPUT_TORQUE,
    traits=(Trait.LOAD, Trait.SHOWN_BY_REVERSALS),
)
