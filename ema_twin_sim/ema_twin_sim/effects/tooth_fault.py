"""Tooth fault: a pulse of torque [N m] one tooth wide, once per pass of the damaged tooth.

Passes per motor revolution (order): 1; 2.25 for a tooth of the sun; 0.75 for a planet or the fixed ring; 0.7258 for the
output ring. The pulse is a raised cosine as wide as one mesh cycle (1/15.75 of a motor revolution).
"""

import math

from .effect import DRY_LEVEL, TORQUE, Effect, Parameter, Trait

_MESH_ORDER = 15.75


def act(at, p):
    """Torque or dry level [N m] at the motor counter's angle."""
    turn = (p[2] * at.motor_angle - p[1]) / (2.0 * math.pi)
    half = 0.5 * p[2] / _MESH_ORDER
    away = abs(turn - math.floor(turn + 0.5))
    return p[0] * 0.5 * (1.0 + math.cos(math.pi * away / half)) if away < half else 0.0


EFFECT = Effect(
    id="tooth_fault",
    summary="a damaged tooth: a pulse each time it meshes",
    equation="L (dissipative) or T (conservative) = torque · pulse((order·θ − position) / 2π)",
    depends_on="order",
    signature="narrow pulses in the current, evenly spaced in the motor's angle",
    shown_by="slow motion over several passes of the tooth",
    source="pass orders from the gearbox's kinematics (63/21 sun and fixed ring, 62/20 output ring)",
    parameters=(
        Parameter("torque", "N m", 0.05, 0.0, math.inf, "height of the pulse, fast shaft"),
        Parameter(
            "position",
            "rad",
            0.0,
            -6.284,
            6.284,
            "where in a pass the pulse is, at the counter's zero",
            starts=tuple(2.0 * math.pi * k / 32 for k in range(32)),
        ),
    ),
    options={"order": ("1", "2.25", "0.75", "0.7258"), "kind": ("dissipative", "conservative")},
    option_value=lambda options: float(options["order"]),
    act=act,
    place=lambda options: DRY_LEVEL if options["kind"] == "dissipative" else TORQUE,
    traits=(Trait.OF_TEETH,),
)
