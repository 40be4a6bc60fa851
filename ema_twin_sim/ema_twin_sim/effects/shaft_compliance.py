"""Shaft compliance: T_t = stiffness * (theta - ratio * theta_o) + damping * (w - ratio * w_o) [N m], at the fast shaft.

Added to a rigid transmission, it makes it a two-inertia one; with backlash, the spring is behind the gap.
"""

import math

from .effect import POSITIVE, Effect, Implausible, Parameter, Trait


def settle(plant, parameters, options):
    """Put the spring and damper between motor and output, instead of the stiff contact."""
    plant["two_inertia"] = 1.0
    plant["contact_stiffness"] = parameters["stiffness"]
    plant["contact_damping"] = parameters["damping"]


def _damping_ratio(values, circumstances):
    """Damping ratio of two inertias on a spring: damping / 2 * sqrt((1 / J_m + 1 / J_o) / stiffness)."""
    softness = 1.0 / circumstances.motor_inertia + 1.0 / max(circumstances.output_inertia, 1e-12)
    return 0.5 * values["damping"] * math.sqrt(softness / values["stiffness"])


EFFECT = Effect(
    id="shaft_compliance",
    summary="a transmission that gives way: shafts, teeth, couplings",
    equation="T_t = stiffness · (θ − ratio·θ_o) + damping · (ω − ratio·ω_o)",
    depends_on="encoders",
    signature="the encoders differ in proportion to the transmitted torque; ringing after steps",
    shown_by="steps or fast sines, with the output encoder recorded",
    source="Rivin, Stiffness and Damping in Mechanical Design, 1999",
    parameters=(
        Parameter(
            "stiffness",
            "N m/rad",
            10.0,
            POSITIVE,
            math.inf,
            "stiffness at the fast shaft",
            starts=(3.0, 8.0, 20.0, 60.0, 200.0),
            neutral=None,
        ),
        Parameter("damping", "N m s/rad", 0.005, 0.0, math.inf, "damping at the fast shaft", starts=(0.01,)),
    ),
    settle=settle,
    repeatable=False,
    traits=(Trait.SPRING,),
    implausible=(
        Implausible(
            "damping",
            lambda v, c: _damping_ratio(v, c) > 1.0,
            "a shaft damped beyond its own ringing is no spring: is it a delay of the encoder?",
        ),
        Implausible(
            "damping",
            lambda v, c: _damping_ratio(v, c) < 1e-4,
            "no shaft rings forever: is it play that makes it ring?",
        ),
        Implausible(
            "stiffness",
            lambda v, c: c.dry_level / v["stiffness"] > 0.5 * c.travel,
            "friction alone would wind the shaft up over half of all that moved",
        ),
    ),
)
