"""Viscous friction: T = coefficient * w [N m], proportional to the speed of the fast shaft [rad/s].

Thesis, script "Main HF": dynamics.CM (motor side) and dynamics.CU (output side, reduced to the fast shaft).
"""

import math

from .effect import Effect, Parameter, Trait


def settle(plant, parameters, options):
    """Add to the coefficient of the side it acts on."""
    plant[f"{options['side']}_viscous"] += parameters["coefficient"]


EFFECT = Effect(
    id="viscous_friction",
    summary="friction proportional to speed: bearings, seals, lubricant",
    equation="T = coefficient · ω",
    depends_on="speed",
    signature="current error that grows with speed and changes sign with direction",
    shown_by="motion at several speeds",
    source="thesis, script Main HF, dynamics.CM and dynamics.CU",
    parameters=(Parameter("coefficient", "N m s/rad", 0.0255, 0.0, math.inf, "torque per speed, at the fast shaft"),),
    options={"side": ("motor", "output")},
    settle=settle,
    every_machine=True,
    traits=(Trait.VISCOUS_FRICTION, Trait.LIKE_A_CONSTANT, Trait.NOT_AT_REST),
)
