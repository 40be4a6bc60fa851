"""Presliding friction: z' = w - stiffness |w| z / L, T = stiffness z + damping z' [N m], a bristle in place of L sgn w.

Before it slides, a contact yields like a spring (Dahl 1968; LuGre: Canudas de Wit, Olsson, Astrom, Lischinsky 1995).
L [N m] is the motor side's dry level; the bristle's state z [rad] starts at 0.
"""

import math

from .effect import POSITIVE, Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Replace dry friction by the bristle (with backlash on both sides, in proportion to their levels)."""
    plant["bristle_stiffness"] = parameters["stiffness"]
    plant["bristle_damping"] = parameters["damping"]


EFFECT = Effect(
    id="presliding_friction",
    summary="dry friction that gives way like a spring before it slides",
    equation="ż = ω − stiffness·|ω|·z/L, T = stiffness·z + damping·ż",
    depends_on="speed",
    signature="current error at reversals only: friction turns over a way instead of at once",
    shown_by="many slow reversals, such as a triangle of small travel",
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
    traits=(Trait.BRISTLE, Trait.ACTS_AT_REVERSALS, Trait.LIKE_PLAY_OR_SPRING, Trait.TRANSIENT),
    implausible=(
        Implausible(
            "stiffness",
            lambda v, c: c.dry_level / v["stiffness"] > min(3.0, 0.5 * c.travel),
            "the contact would give way over half of all that moved: is it a spring load?",
        ),
        Implausible(
            "damping",
            lambda v, c: v["damping"] > 10.0 * c.viscous > 0.0,
            "the bristle would damp more than all lubricant",
        ),
    ),
)
