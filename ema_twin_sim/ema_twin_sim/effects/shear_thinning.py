"""Shear thinning: T = -fraction * b * w * |w| / (|w| + speed) [N m]; b is the model's viscous coefficient [N m s/rad].

The lubricant thins with the shear rate (Cross 1965), so the friction curve bends down at speed. On the measured joints
of two robots it was mistaken for a negative quadratic drag or a negative Stribeck term.
"""

import math

from .effect import POSITIVE, VISCOUS_COEFFICIENT, Effect, Implausible, Parameter, Trait


def act(at, p):
    """Change of the viscous coefficient [N m s/rad] at the motor's speed."""
    size = abs(at.motor_speed)
    return -p[0] * at.viscous_coefficient * size / (size + p[1])


EFFECT = Effect(
    id="shear_thinning",
    summary="a lubricant that thins with speed: friction bends down",
    equation="T = −fraction · b · ω · |ω| / (|ω| + speed)",
    depends_on="speed",
    signature="current error along the motion that grows with speed, and flattens",
    shown_by="ramps from slow to fast",
    source="Cross 1965",
    parameters=(
        Parameter("fraction", "1", 0.3, 0.0, 1.0, "share of the viscous friction lost at infinite speed"),
        Parameter(
            "speed",
            "rad/s",
            10.0,
            POSITIVE,
            math.inf,
            "speed at which half of that share is lost, fast shaft",
            starts=(1.0, 3.0, 10.0, 30.0),
        ),
    ),
    act=act,
    place=VISCOUS_COEFFICIENT,
    traits=(Trait.NOT_AT_REST,),
    implausible=(
        Implausible(
            "fraction",
            lambda v, c: v["fraction"] > 0.95,
            "a lubricant does not lose nearly all its friction: is the viscous coefficient too large?",
        ),
    ),
)
