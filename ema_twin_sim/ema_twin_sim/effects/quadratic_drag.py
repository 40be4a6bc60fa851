"""Quadratic drag: T = coefficient * w * |w| [N m], churning oil or air at high speed."""

import math

from .effect import Effect, Implausible, Parameter, Trait


def act(at, p):
    """Torque [N m] at the motor's speed."""
    return p[0] * at.motor_speed * abs(at.motor_speed)


EFFECT = Effect(
    id="quadratic_drag",
    summary="drag that grows with the square of speed: churned lubricant, air",
    equation="T = coefficient · ω · |ω|",
    depends_on="speed",
    signature="current error against the motion that grows faster than speed",
    shown_by="fast motion",
    source="Armstrong-Hélouvry, Dupont, Canudas de Wit 1994",
    parameters=(
        Parameter("coefficient", "N m s^2/rad^2", 5e-4, 0.0, math.inf, "torque per squared speed, fast shaft"),
    ),
    act=act,
    traits=(Trait.NOT_AT_REST,),
    implausible=(
        Implausible(
            "coefficient",
            lambda v, c: v["coefficient"] * c.top_speed**2 > 3.0 * (c.dry_level + c.viscous * c.top_speed) > 0.0,
            "more than three times all other friction at top speed: is the viscous friction taken too small?",
        ),
    ),
)
