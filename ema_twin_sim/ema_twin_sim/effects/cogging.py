"""Cogging: T = torque * sin(order * theta + phase) [N m], from the motor's teeth and magnets, at any current.

Order 24 on this motor (least common multiple of slots and poles). Another motor has one or several of the other orders,
or one found from its recordings.
"""

import math

from .effect import Effect, Parameter, Trait


def act(at, p):
    """Torque [N m] at the motor counter's angle."""
    return p[0] * math.sin(p[2] * at.motor_angle + p[1])


EFFECT = Effect(
    id="cogging",
    summary="the motor's detent torque, independent of current",
    equation="T = torque · sin(order·θ + phase)",
    depends_on="order",
    signature="current error of order 24 with the same amplitude at every current",
    shown_by="slow motion over a motor turn",
    source="Hanselman, Brushless Permanent Magnet Motor Design, 2003",
    parameters=(
        Parameter("torque", "N m", 0.03, 0.0, math.inf, "amplitude, fast shaft"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the motor counter's zero", periodic=True),
    ),
    options={"order": ("24", "12", "36", "48", "72", "144", "18", "6")},
    free_option="order",
    option_value=lambda options: float(options["order"]),
    act=act,
    traits=(Trait.MOTOR_WAVE,),
)
