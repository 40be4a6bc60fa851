"""Coulomb friction: a dry level [N m] that opposes motion; at rest it holds up to static_ratio times that level.

Thesis, script "Main HF": dynamics.friction (FDTm, FDTu sliding; FSTm, FSTu at rest), its "Borello" friction block.
"""

import math

from .effect import Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Add to the sliding and the break-away level of the side it acts on."""
    side = options["side"]
    plant[f"{side}_dry"] += parameters["torque"]
    plant[f"{side}_break_away"] += parameters["torque"] * parameters["static_ratio"]


EFFECT = Effect(
    id="coulomb_friction",
    summary="dry friction of constant level",
    equation="T = torque · sgn ω; at rest it holds up to static_ratio · torque",
    depends_on="speed",
    signature="current error that is constant in each direction and flips at a reversal",
    shown_by="slow motion in both directions",
    source="thesis, script Main HF, dynamics.friction (Borello friction block)",
    parameters=(
        Parameter("torque", "N m", 0.05, 0.0, math.inf, "sliding level, at the fast shaft"),
        Parameter("static_ratio", "1", 2.0, 1.0, 10.0, "break-away over sliding level", starts=(2.0,), at_rest=True),
    ),
    options={"side": ("motor", "output")},
    settle=settle,
    every_machine=True,
    traits=(Trait.DRY_FRICTION, Trait.LIKE_A_CONSTANT),
    implausible=(
        Implausible(
            "static_ratio",
            lambda v, c: v["static_ratio"] > 5.0,
            "break-away is some times the sliding level, not that many",
        ),
    ),
)
