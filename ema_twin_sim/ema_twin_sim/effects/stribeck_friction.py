"""Stribeck friction: a dry level torque * f(|w| / speed) [N m], which fades as a film builds up; also at rest.

The law f(x) is exponential, exp(-x) (Bo and Pavelescu 1982), Gaussian, exp(-x^2), or Lorentzian, 1 / (1 + x^2), as in
Armstrong-Helouvry, Dupont and Canudas de Wit, "A survey of models, analysis tools and compensation methods for the
control of machines with friction" (1994).
"""

import math

from .effect import DRY_LEVEL, POSITIVE, Effect, Implausible, Parameter, Trait

LAWS = {"exponential": 0.0, "gaussian": 1.0, "lorentzian": 2.0}


def act(at, p):
    """Dry level [N m] at the motor's speed."""
    share = abs(at.motor_speed) / p[1]
    if p[2] == 2.0:
        return p[0] / (1.0 + share * share)
    return p[0] * math.exp(-share * share if p[2] == 1.0 else -share)


EFFECT = Effect(
    id="stribeck_friction",
    summary="extra dry friction at low speed, before a lubricant film carries",
    equation="L = torque · f(|ω| / speed), f(x) = exp(−x), exp(−x²) or 1 / (1 + x²)",
    depends_on="speed",
    signature="current error at low speed only, against the motion, gone above a few times the Stribeck speed",
    shown_by="slow ramps, down to a tenth of the speeds of these",
    source="Bo and Pavelescu 1982; Armstrong-Hélouvry, Dupont, Canudas de Wit 1994",
    parameters=(
        Parameter("torque", "N m", 0.05, 0.0, math.inf, "extra level at zero speed"),
        Parameter(
            "speed",
            "rad/s",
            2.0,
            POSITIVE,
            math.inf,
            "speed at which it has fallen to 1/e, or with the Lorentzian law to 1/2, fast shaft",
            starts=(0.3, 0.6, 1.2, 2.5, 5.0),
            driven=1.0,
        ),
    ),
    options={"law": tuple(LAWS)},
    law="law",
    option_value=lambda options: LAWS[options["law"]],
    act=act,
    place=DRY_LEVEL,
    traits=(Trait.ABOVE_DRY_FRICTION, Trait.NOT_AT_REST),
    implausible=(
        Implausible(
            "speed",
            lambda v, c: v["speed"] > c.top_speed,
            "faster than anything recorded: it acts as plain Coulomb friction here",
        ),
        Implausible(
            "torque",
            lambda v, c: c.dry_level > 0.0 and v["torque"] > 5.0 * c.dry_level,
            "more than five times the sliding level: is the Coulomb friction taken too small?",
        ),
    ),
)
