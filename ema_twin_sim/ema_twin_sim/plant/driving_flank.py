"""Where in its play an output begins: on the driving flank where the motor moves, else in the middle of the gap."""

import math

from numba import njit

from ..criteria import STANDSTILL


@njit(error_model="numpy")
def ahead(gap, dry, viscous, stiffness, speed):
    """By how much [rad] a motor of this ``speed`` [rad/s] is ahead of its output as a motion begins, at the fast shaft.

    One that moves drives the output along: teeth of this ``stiffness`` [N m/rad] touch, and what the output's ``dry``
    [N m] and ``viscous`` [N m s/rad] friction take presses them. At rest, and without play, it is 0.
    """
    if gap == 0.0 or math.fabs(speed) <= STANDSTILL:
        return 0.0
    return math.copysign(gap + (dry + viscous * math.fabs(speed)) / stiffness, speed)
