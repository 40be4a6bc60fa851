"""Thermal friction: T = -fraction * b * w * (1 - exp(-t / time_constant)) [N m], t [s] from a cold start.

The lubricant warms as the machine runs, and the model's viscous coefficient b [N m s/rad] falls.
"""

import math

from .effect import Effect, Parameter


def act(at, p):
    """Torque [N m] at a time since the cold start: what the warm lubricant takes less."""
    return -p[0] * at.viscous_coefficient * at.motor_speed * (1.0 - math.exp(-at.time / p[1]))


EFFECT = Effect(
    id="thermal_friction",
    summary="viscous friction that falls as the machine warms up",
    equation="T = −fraction · b · ω · (1 − exp(−t / time_constant))",
    signature="current error along the motion that grows with time and speed, and settles",
    source="first-order warming; Bittencourt and Axelsson 2014 for its size in gearboxes",
    parameters=(
        Parameter("fraction", "1", 0.25, 0.0, 1.0, "share of the viscous friction lost when warm"),
        Parameter("time_constant", "s", 12.0, 1.0, 10000.0, "time constant of the warming"),
    ),
    act=act,
)
