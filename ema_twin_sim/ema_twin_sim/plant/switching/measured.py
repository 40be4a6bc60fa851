"""Signal acquisition: quadrature and direct current and quadrature voltage, as the drive works them out.

The drive knows the healthy shapes at the angle of its resolver and nothing else. Source: the thesis's block "Signal
acquisition", outputs I_3eq, Id and V_3eq, filter simulation.tauFilter (5*10e-5 s in the script: 0.5 ms). Each function
takes values of phases u, v, w; those of currents add up to zero, those of voltages may be taken to any common point.
"""

from ..compiled import compiled
from .shapes import HALF_ROOT_OF_THREE


@compiled
def in_quadrature(sine, cosine, u, v, w):
    """Sum of the values, each weighed by its sine (``shapes.three_phases``): 3/2 of Park's quadrature component."""
    return sine * (u - 0.5 * (v + w)) - cosine * (HALF_ROOT_OF_THREE * (v - w))


@compiled
def direct(sine, cosine, u, v, w):
    """3/2 of Park's direct component, along the magnets' flux: negative currents weaken it."""
    return -cosine * (u - 0.5 * (v + w)) - sine * (HALF_ROOT_OF_THREE * (v - w))


@compiled
def weighed(shape_u, shape_v, shape_w, u, v, w):
    """Sum of the values, each weighed by its shape."""
    return shape_u * u + shape_v * v + shape_w * w


@compiled
def filtered(before, now, gain):
    """First-order lag after a step in which its input was ``now``."""
    return before + gain * (now - before)
