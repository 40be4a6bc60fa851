"""Current offset: T = torque * sin(P theta + phase) [N m], once per electrical turn, for P pole pairs.

A current sensor with a zero offset makes the drive inject a constant phase current, whose torque oscillates once per
electrical revolution. A model that names no pole pairs has the four of the bench's motor.
"""

import math

from .effect import Effect, Parameter

_POLE_PAIRS = 4.0


def act(at, p):
    """Torque [N m] at the motor counter's angle."""
    electrical = _POLE_PAIRS * at.motor_angle if math.isnan(at.electrical_angle) else at.electrical_angle
    return p[0] * math.sin(electrical + p[1])


EFFECT = Effect(
    id="current_offset",
    summary="offset of a phase current sensor",
    equation="T = torque · sin(P·θ + phase), P pole pairs",
    depends_on="direction",
    signature="current error of the electrical order (4), independent of load",
    shown_by="slow motion over several motor turns",
    source="Chung and Sul 1998",
    parameters=(
        Parameter("torque", "N m", 0.02, 0.0, math.inf, "amplitude, fast shaft"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the motor counter's zero", periodic=True),
    ),
    act=act,
)
