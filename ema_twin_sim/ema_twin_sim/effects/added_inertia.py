"""Added inertia: T = inertia * dw/dt [N m], kg m^2 at the fast shaft, on the output side of the gearbox."""

import math

from .effect import Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Add to the output inertia."""
    plant["output_inertia"] += parameters["inertia"]


EFFECT = Effect(
    id="added_inertia",
    summary="a heavier load than the model has",
    equation="T = inertia · dω/dt",
    depends_on="acceleration",
    signature="current error in proportion to acceleration",
    shown_by="hard acceleration: steps, fast sines",
    source="Newton's second law",
    parameters=(Parameter("inertia", "kg m^2", 5e-4, 0.0, math.inf, "more inertia, reduced to the fast shaft"),),
    settle=settle,
    traits=(Trait.LIKE_A_CONSTANT, Trait.LIKE_PLAY_OR_SPRING, Trait.TRANSIENT),
    told_by="an inertia that is known better would tell",
    implausible=(
        Implausible(
            "inertia",
            lambda v, c: v["inertia"] > 3.0 * (c.motor_inertia + c.output_inertia),
            "more than three times the machine's own: is the model that of this machine?",
        ),
    ),
)
