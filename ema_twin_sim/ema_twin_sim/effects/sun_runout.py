"""Sun run-out: torque * sin(theta + phase) [N m], once per turn of the motor shaft.

An eccentric sun gear presses its meshes once per turn: the load on the teeth, and with it their friction, varies with
the shaft's angle (dissipative), or the shaft is pushed back and forth (conservative). The current with a period of 5 s
at 0.01 rad/s in the thesis is this (2 pi / 1.24 = 5.07 s), not the mesh.
"""

import math

from .effect import DRY_LEVEL, TORQUE, Effect, Implausible, Parameter


def act(at, p):
    """Dry level or torque [N m] at the motor counter's angle."""
    return p[0] * math.sin(at.motor_angle + p[1])


EFFECT = Effect(
    id="sun_runout",
    summary="friction or torque that swings once per motor turn: an eccentric sun gear or shaft",
    equation="L (dissipative) or T (conservative) = torque · sin(θ + phase)",
    depends_on="order",
    signature="current error of order 1, once per motor revolution",
    shown_by="slow motion over several motor turns, in both directions",
    source="thesis, chapter 5 (the 5 s period of the current at 0.01 rad/s)",
    parameters=(
        Parameter("torque", "N m", 0.02, 0.0, math.inf, "amplitude, at the fast shaft"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the motor counter's zero", periodic=True),
    ),
    options={"kind": ("dissipative", "conservative")},
    act=act,
    place=lambda options: DRY_LEVEL if options["kind"] == "dissipative" else TORQUE,
    implausible=(
        Implausible(
            "torque",
            lambda v, c: c.dry_level > 0.0 and v["torque"] > c.dry_level,
            "more than the Coulomb friction that it modulates: friction would be negative",
        ),
    ),
)
