"""Back-EMF shapes of the three phases over the electrical angle, with unit amplitude.

Phases v and w follow u by a third and two thirds of an electrical turn; currents with these shapes make torque.
"""

import math

import numpy as np

from ..compiled import compiled

HALF_ROOT_OF_THREE = 0.5 * math.sqrt(3.0)


@compiled
def three_phases(sine, cosine):
    """(u, v, w): sin(x), sin(x - 2 pi / 3), sin(x + 2 pi / 3) from one sine and cosine of x."""
    half = -0.5 * sine
    across = HALF_ROOT_OF_THREE * cosine
    return sine, half - across, half + across


@compiled
def trapezoid(turns):
    """Trapezoid over an angle in turns: rises from 0 to 1 in 30 deg, stays for 120 deg, then symmetric like a sine."""
    later = turns + 0.75
    triangle = 3.0 * (4.0 * math.fabs(later - np.floor(later) - 0.5) - 1.0)
    return 1.0 if triangle > 1.0 else (-1.0 if triangle < -1.0 else triangle)


@compiled
def three_trapezoids(turns):
    """(u, v, w) of a motor with trapezoidal back-EMF at an electrical angle in turns."""
    return trapezoid(turns), trapezoid(turns - 1.0 / 3.0), trapezoid(turns + 1.0 / 3.0)
