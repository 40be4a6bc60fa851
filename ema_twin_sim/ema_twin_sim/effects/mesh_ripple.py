"""Mesh ripple: T = torque * sum over k = 1, 3, 5 of sin(k (order * theta + phase)) / k [N m], at the tooth mesh.

The mesh stiffness changes in steps as one or two pairs of teeth carry. Orders (cycles per motor revolution): 15.75 the
first mesh (63/4), 15.0 the second, 45 its third harmonic, which the three output meshes do not cancel.
"""

import math

from .effect import Effect, Parameter, Trait


def act(at, p):
    """Torque [N m] at the motor counter's angle."""
    angle = p[2] * at.motor_angle + p[1]
    return p[0] * (math.sin(angle) + math.sin(3.0 * angle) / 3.0 + math.sin(5.0 * angle) / 5.0)


EFFECT = Effect(
    id="mesh_ripple",
    summary="torque that swings with each tooth: mesh stiffness, tooth errors",
    equation="T = torque · Σ sin(k(order·θ + phase))/k, k = 1, 3, 5",
    depends_on="order",
    signature="current error of order 15.75 (15.0, 45) and its odd harmonics",
    shown_by="slow motion over several motor turns",
    source="thesis, eqs 3.52-3.60, over the sun's angle instead of time",
    parameters=(
        Parameter("torque", "N m", 0.02, 0.0, math.inf, "amplitude of the fundamental, fast shaft"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the motor counter's zero", periodic=True),
    ),
    options={"order": ("15.75", "15.0", "45")},
    free_option="order",
    option_value=lambda options: float(options["order"]),
    act=act,
    traits=(Trait.GEAR_WAVE, Trait.OF_TEETH),
)
