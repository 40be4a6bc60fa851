"""Torque ripple: T = -Kt * i * fraction * sin(6 P theta + phase) [N m], the sixth harmonic of P pole pairs.

The back-EMF or the currents are not sinusoidal: the torque oscillates in proportion to the current. A model that names
no pole pairs has the four of the bench's motor.
"""

import math

from .effect import Effect, Implausible, Parameter, Trait

_POLE_PAIRS = 4.0


def act(at, p):
    """Torque [N m] that the motor lacks, at its counter's angle."""
    electrical = _POLE_PAIRS * at.motor_angle if math.isnan(at.electrical_angle) else at.electrical_angle
    return -at.motor_torque * p[0] * math.sin(6.0 * electrical + p[1])


EFFECT = Effect(
    id="torque_ripple",
    summary="motor torque that swings with the electrical angle, in proportion to current",
    equation="T = −Kt · i · fraction · sin(6·P·θ + phase), P pole pairs",
    depends_on="order",
    signature="current error of six times the electrical order (24) that grows and changes sign with the current",
    shown_by="slow motion under load",
    source="Holtz and Springob 1996",
    parameters=(
        Parameter("fraction", "1", 0.05, 0.0, 1.0, "amplitude over the mean torque"),
        Parameter("phase", "rad", 0.0, -6.284, 6.284, "phase at the motor counter's zero", periodic=True),
    ),
    act=act,
    traits=(Trait.BY_CURRENT,),
    implausible=(
        Implausible(
            "fraction",
            lambda v, c: v["fraction"] > 0.3,
            "a motor whose torque ripples by a third is broken: is it cogging?",
        ),
    ),
)
