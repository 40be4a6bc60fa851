"""Sine and cosine of the electrical angle: computed from the angle, or rotated by a step's increment."""

import math

import numpy as np

from ..compiled import compiled


@compiled
def sine_and_cosine(turns):
    """(sine, cosine) of an angle in turns, to 1e-15 of full scale, at half the cost of two library calls.

    The angle is folded to an eighth of a turn on either side of the nearest quarter; there the minimax polynomials of
    Sun's fdlibm (k_sin.c, k_cos.c) are summed in pairs, so that a processor can compute several terms at once.
    """
    quarters = np.floor(4.0 * turns + 0.5)
    x = (4.0 * turns - quarters) * (0.5 * math.pi)
    z = x * x
    zz = z * z
    odd = (8.33333333332248946124e-03 + z * -1.98412698298579493134e-04) + zz * (
        (2.75573137070700676789e-06 + z * -2.50507602534068634195e-08) + zz * 1.58969099521155010221e-10
    )
    even = (4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) + zz * (
        (2.48015872894767294178e-05 + z * -2.75573143513906633035e-07)
        + zz * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    )
    near_sine = x + x * z * (-1.66666666666666324348e-01 + z * odd)
    near_cosine = (1.0 - 0.5 * z) + zz * even
    quarter = int(quarters) & 3
    crosswise = (quarter & 1) != 0
    sine = near_cosine if crosswise else near_sine
    cosine = near_sine if crosswise else near_cosine
    return -sine if quarter >= 2 else sine, -cosine if quarter == 1 or quarter == 2 else cosine


@compiled
def turned(sine, cosine, angle):
    """(sine, cosine) after a further small ``angle`` [rad]: angle-sum formula, both series up to the fourth power.

    A third of the cost of ``sine_and_cosine``. The error per step, angle^5 / 120, is 1e-17 at 1 us and 100 rad/s and
    3e-15 at 8000 rpm, four pole pairs; it accumulates, so start again with every control cycle.
    """
    square = angle * angle
    rise = angle - angle * square * (1.0 / 6.0)
    fall = square * (0.5 - square * (1.0 / 24.0))
    return sine + (cosine * rise - sine * fall), cosine - (sine * rise + cosine * fall)
