"""Spring load: T = stiffness * (theta_o - relaxed) [N m at the fast shaft per rad of the output].

A spring that a rig is wound up against is relaxed where the recording starts; a return spring is relaxed at an angle of
its own, from wherever the recording starts.
"""

import math

from .effect import OUTPUT_TORQUE, Effect, Parameter, Trait

PLACES = {"start": 0.0, "angle": 1.0}


def act(at, p):
    """Torque [N m] at the output's travel, or at its own angle."""
    return p[0] * (at.output_travel if p[2] == 0.0 else at.output_angle - p[1])


EFFECT = Effect(
    id="spring_load",
    summary="a spring on the output, relaxed where the recording starts, or at an angle of its own",
    equation="T = stiffness · (θ_o − θ_o at the start), or stiffness · (θ_o − angle)",
    depends_on="output_position",
    signature="current error that grows with the output's travel, the same in both directions",
    shown_by="travel as large as the machine allows, in both directions",
    source="Hooke's law",
    parameters=(
        Parameter("stiffness", "N m/rad", 0.05, 0.0, math.inf, "torque at the fast shaft per radian of the output"),
        Parameter(
            "angle",
            "rad",
            0.0,
            -math.inf,
            math.inf,
            "where it is relaxed, by the output's encoder",
            choice="angle",
        ),
    ),
    options={"relaxed": tuple(PLACES)},
    law="relaxed",
    option_value=lambda options: PLACES[options["relaxed"]],
    act=act,
    place=OUTPUT_TORQUE,
    traits=(Trait.LOAD, Trait.WOUND_UP),
)
