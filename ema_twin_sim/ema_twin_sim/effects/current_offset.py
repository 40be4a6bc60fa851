"""Current offset: T = torque * sin(4 theta + phase) [N m], once per electrical turn of the four pole pairs.

A current sensor with a zero offset makes the drive inject a constant phase current, whose torque oscillates once per
electrical revolution.
"""

import math

from .effect import Effect, Parameter

_POLE_PAIRS = 4.0


def act(at, p):
    """Torque [N m] at the motor counter's angle."""
    return p[0] * math.sin(_POLE_PAIRS * at.motor_angle + p[1])


EFFECT = Effect(
    id="current_offset",
    summary="offset of a phase current sensor",
    equation="T = torque · sin(4θ + phase)",
    depends_on="direction",
    signature="current error of order 4, the electrical frequency, independent of load",
    shown_by="slow motion over several motor turns",
    source="Chung and Sul 1998",
    parameters=(
        Parameter("torque", "N m", 0.02, 0.0, math.inf, "amplitude, fast shaft"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the motor counter's zero", periodic=True),
    ),
    act=act,
)
