"""Spring load: T = stiffness * (theta_o - theta_o at the start) [N m at the fast shaft per rad of the output]."""

import math

from .effect import OUTPUT_TORQUE, Effect, Parameter, Trait


def act(at, p):
    """Torque [N m] at the output's travel."""
    return p[0] * at.output_travel


EFFECT = Effect(
    id="spring_load",
    summary="a spring on the output, relaxed where the recording starts",
    equation="T = stiffness · (θ_o − θ_o at the start)",
    depends_on="output_position",
    signature="current error that grows with the output's travel, the same in both directions",
    shown_by="travel as large as the machine allows, in both directions",
    source="Hooke's law",
    parameters=(
        Parameter("stiffness", "N m/rad", 0.05, 0.0, math.inf, "torque at the fast shaft per radian of the output"),
    ),
    act=act,
    place=OUTPUT_TORQUE,
    traits=(Trait.LOAD, Trait.WOUND_UP),
)
