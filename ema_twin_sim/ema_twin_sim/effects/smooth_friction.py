"""Smooth friction: dry friction L * f(|w| / speed) [N m] in place of L, so that it builds up with speed.

L [N m] is the dry level, with backlash or compliance that of the motor's side. A grease that yields, or many contacts
that turn round one after another, have no level at standstill: the shaft creeps. Simulators use the same laws in place
of a jump: f(x) = tanh(x), (2/pi) arctan(pi x / 2), or x / sqrt(1 + x^2). All begin as steeply, f(x) = x, and end at 1,
the later ones more slowly. Andersson, Soderberg, Bjorklund, "Friction models for sliding dry, boundary and mixed
lubricated contacts" (2007), section 2; Pennestri, Rossi, Salvini, Valentini, "Review and comparison of dry friction
force models" (2016), section 2.
"""

import math

from .effect import DRY_LEVEL, POSITIVE, Effect, Implausible, Parameter, Trait

LAWS = {"tanh": 0.0, "arctangent": 1.0, "root": 2.0}


def act(at, p):
    """Change of the dry level [N m] at the motor's speed: what it lacks of the whole."""
    share = abs(at.motor_speed) / p[0]
    if p[1] == 0.0:
        built = math.tanh(share)
    elif p[1] == 1.0:
        built = math.atan(0.5 * math.pi * share) * 2.0 / math.pi
    else:
        built = abs(at.motor_speed) / math.hypot(at.motor_speed, p[0])
    return -at.dry_level * (1.0 - built)


def settle(plant, parameters, options):
    """Let the level at rest be what slides: a shaft that creeps has nothing to break away from."""
    plant["motor_break_away"] = plant["motor_dry"]
    if not plant["two_inertia"]:
        plant["output_break_away"] = plant["output_dry"]


EFFECT = Effect(
    id="smooth_friction",
    summary="dry friction that builds up with speed instead of turning at once",
    equation="L = level · f(|ω| / speed), f(x) = tanh x, (2/π) arctan(π x / 2) or x / √(1 + x²)",
    depends_on="speed",
    signature="current error against the friction near standstill only: it turns round over a range of speeds",
    shown_by="slow reversals, such as a slow sine",
    source="Andersson, Söderberg, Björklund 2007; Pennestrì, Rossi, Salvini, Valentini 2016",
    parameters=(
        Parameter(
            "speed",
            "rad/s",
            1.0,
            POSITIVE,
            math.inf,
            "speed at which it would reach its level if it rose as from standstill, fast shaft",
            starts=(0.1, 0.3, 1.0, 3.0),
            neutral=None,
            driven=0.2,
        ),
    ),
    options={"law": tuple(LAWS)},
    law="law",
    option_value=lambda options: LAWS[options["law"]],
    act=act,
    settle=settle,
    place=DRY_LEVEL,
    repeatable=False,
    traits=(
        Trait.ABOVE_DRY_FRICTION,
        Trait.SCALES_DRY_FRICTION,
        Trait.ACTS_AT_REVERSALS,
        Trait.LIKE_PLAY_OR_SPRING,
        Trait.NOT_AT_REST,
    ),
    implausible=(
        Implausible(
            "speed",
            lambda v, c: v["speed"] > 0.2 * c.top_speed,
            "it builds up over a large part of the speeds recorded: is it viscous friction, or a lubricant that thins?",
        ),
    ),
)
