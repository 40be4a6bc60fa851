"""Gravity load: T = torque * sin(theta_o + angle) [N m], an arm or an unbalance on the output, at the fast shaft."""

import math

from .effect import OUTPUT_TORQUE, Effect, Parameter, Trait


def act(at, p):
    """Torque [N m] at the output encoder's own angle."""
    return p[0] * math.sin(at.output_angle + p[1])


EFFECT = Effect(
    id="gravity_load",
    summary="an unbalanced arm on the output",
    equation="T = torque · sin(θ_o + angle)",
    depends_on="output_position",
    signature="current error that follows the sine of the output's angle, the same in both directions",
    shown_by="travel over a large part of an output turn",
    source="statics",
    parameters=(
        Parameter("torque", "N m", 0.06, 0.0, math.inf, "amplitude, reduced to the fast shaft"),
        Parameter("angle", "rad", 0.0, -6.284, 6.284, "angle of the arm at the output encoder's zero", periodic=True),
    ),
    act=act,
    place=OUTPUT_TORQUE,
    traits=(Trait.LOAD, Trait.OF_OUTPUT_TURNS),
)
