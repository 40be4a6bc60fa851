"""Presliding friction: z' = w - stiffness |w| z / L, T = stiffness z + damping z' [N m], a bristle in place of L sgn w.

Before it slides, a contact gives way like a spring (Dahl 1968; LuGre: Canudas de Wit, Olsson, Astrom, Lischinsky 1995).
L [N m] is the motor side's dry level; the bristle's state z [rad] starts relaxed.
"""

import math

from .effect import POSITIVE, Effect, Parameter


def settle(plant, parameters, options):
    """Replace dry friction by the bristle (on both sides of a transmission with play, shared as their levels)."""
    plant["bristle_stiffness"] = parameters["stiffness"]
    plant["bristle_damping"] = parameters["damping"]


EFFECT = Effect(
    id="presliding_friction",
    summary="dry friction that gives way like a spring before it slides",
    equation="ż = ω − stiffness·|ω|·z/L, T = stiffness·z + damping·ż",
    depends_on="speed",
    signature="current error at reversals only: friction turns over a way instead of at once",
    source="Dahl 1968; Canudas de Wit, Olsson, Åström, Lischinsky 1995",
    parameters=(
        Parameter(
            "stiffness",
            "N m/rad",
            2.0,
            POSITIVE,
            math.inf,
            "stiffness of the bristle, fast shaft",
            starts=(0.3, 1.0, 3.0, 10.0),
            neutral=None,
        ),
        Parameter("damping", "N m s/rad", 0.01, 0.0, math.inf, "damping of the bristle, fast shaft", starts=(0.01,)),
    ),
    settle=settle,
    repeatable=False,
)
