"""Signal acquisition: quadrature and direct current and quadrature voltage, as computed by the drive.

The drive knows only the healthy shapes at the angle of its resolver. Source: the thesis's block "Signal acquisition",
outputs I_3eq, Id and V_3eq, filter simulation.tauFilter (5*10e-5 s in the script: 0.5 ms). Each function takes values
of phases u, v, w; currents add up to zero, voltages may refer to any common point.
"""

from ..compiled import compiled
from .shapes import HALF_ROOT_OF_THREE


@compiled
def in_quadrature(sine, cosine, u, v, w):
    """Sum of the values weighted by their sines (``shapes.three_phases``): 3/2 of Park's quadrature component."""
    return sine * (u - 0.5 * (v + w)) - cosine * (HALF_ROOT_OF_THREE * (v - w))


@compiled
def direct(sine, cosine, u, v, w):
    """3/2 of Park's direct component, along the magnets' flux: negative currents weaken it."""
    return -cosine * (u - 0.5 * (v + w)) - sine * (HALF_ROOT_OF_THREE * (v - w))


@compiled
def weighed(shape_u, shape_v, shape_w, u, v, w):
    """Sum of the values weighted by their shapes."""
    return shape_u * u + shape_v * v + shape_w * w


@compiled
def filtered(before, now, gain):
    """First-order lag after a step with constant input ``now``."""
    return before + gain * (now - before)
