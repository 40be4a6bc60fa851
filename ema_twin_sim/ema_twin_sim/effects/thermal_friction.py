"""Thermal friction: T = -fraction * b * w * (1 - exp(-t / time_constant)) [N m], t [s] from a cold start.

The lubricant warms up as the machine runs, and the model's viscous coefficient b [N m s/rad] falls.
"""

import math

from .effect import POSITIVE, VISCOUS_COEFFICIENT, Effect, Implausible, Parameter, Trait


def act(at, p):
    """Change of the viscous coefficient [N m s/rad] at a time after the cold start."""
    return -p[0] * at.viscous_coefficient * (1.0 - math.exp(-at.time / p[1]))


EFFECT = Effect(
    id="thermal_friction",
    summary="viscous friction that falls as the machine warms up",
    equation="T = −fraction · b · ω · (1 − exp(−t / time_constant))",
    depends_on="time",
    signature="current error along the motion that grows with time and speed, and settles",
    shown_by="a cold start, and several time constants of fast motion",
    source="first-order warming; Bittencourt and Axelsson 2014 for its size in gearboxes",
    parameters=(
        Parameter("fraction", "1", 0.25, 0.0, 1.0, "share of the viscous friction lost when warm"),
        Parameter(
            "time_constant",
            "s",
            12.0,
            POSITIVE,
            math.inf,
            "time constant of the warming",
            starts=(2.0, 5.0, 12.0, 30.0),
        ),
    ),
    act=act,
    place=VISCOUS_COEFFICIENT,
    traits=(Trait.TRANSIENT,),
    implausible=(
        Implausible(
            "time_constant",
            lambda v, c: v["time_constant"] > 3.0 * c.duration,
            "far longer than the recordings: they show a slow drift and not its end; is it a spring or a load?",
        ),
        Implausible(
            "fraction",
            lambda v, c: v["fraction"] > 0.9,
            "a warm lubricant does not lose nearly all its friction",
            never=True,
        ),
    ),
)
