"""Torque ripple: T = -Kt * i * fraction * sin(24 theta + phase) [N m], the sixth harmonic of the four pole pairs.

The back-EMF or the currents are not sinusoidal: the torque oscillates in proportion to the current.
"""

import math

from .effect import Effect, Implausible, Parameter, Trait

_ORDER = 24.0


def act(at, p):
    """Torque [N m] that the motor lacks, at its counter's angle."""
    return -at.motor_torque * p[0] * math.sin(_ORDER * at.motor_angle + p[1])


EFFECT = Effect(
    id="torque_ripple",
    summary="motor torque that swings with the electrical angle, in proportion to current",
    equation="T = −Kt · i · fraction · sin(24θ + phase)",
    depends_on="order",
    signature="current error of order 24 that grows with the current and flips with its sign",
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
