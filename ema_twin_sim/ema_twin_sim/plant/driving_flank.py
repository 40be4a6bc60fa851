"""Initial position of an output in its backlash: on the driving flank if the motor moves, otherwise centred."""

import math

from numba import njit

from ..criteria import STANDSTILL


@njit(error_model="numpy")
def ahead(gap, dry, viscous, stiffness, speed):
    """Lead [rad, fast shaft] of a motor with this ``speed`` [rad/s] over its output at the start of a recording.

    A moving motor drives the output: teeth with this ``stiffness`` [N m/rad] touch, loaded by the output's ``dry``
    [N m] and ``viscous`` [N m s/rad] friction. At rest, and without backlash, it is 0.
    """
    if gap == 0.0 or math.fabs(speed) <= STANDSTILL:
        return 0.0
    return math.copysign(gap + (dry + viscous * math.fabs(speed)) / stiffness, speed)
