"""Bandwidth: how narrow the kernels for a recording may be."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..criteria import NEGLIGIBLE, SMALL
from .held_readings import samples_held
from .smoothing import gaussian, smooth, smooth_way

NARROWER = 0.7  # ratio of one tried width to the next


def narrowest(position: np.ndarray, period: float, noise: float, widest: float, least: float) -> float:
    """Smallest width [s] between ``least`` and ``widest`` whose second derivative of a position (n,) [rad] is quiet.

    ``noise`` [rad] is the standard deviation of one sample.
    """
    allowed = NEGLIGIBLE * float(np.sqrt(np.mean(smooth_way(position, gaussian(widest, period, 2)) ** 2)))
    return _narrowed(lambda width: gaussian(width, period, 2), noise, allowed, widest, least)


def narrowest_of_speed(
    speed: np.ndarray, period: float, noise: float, smoothing: float, widest: float, least: float
) -> float:
    """The same for the first derivative of a speed (n,) [rad/s] that a drive has smoothed by a lag [s].

    Many drives log a speed more often than they compute it: the kernel spans as many periods of its changes as
    ``least`` [s] spans samples. It is no less than a tenth of the widest, which multiplies the rows by ten.
    """
    allowed = NEGLIGIBLE * float(np.sqrt(np.mean(smooth(speed, slope(widest, period, smoothing)) ** 2)))
    least = max(samples_held(speed) * least, SMALL * widest)
    return _narrowed(lambda width: slope(width, period, smoothing), noise, allowed, widest, least)


def narrowest_for_speed(period: float, noise: float, widest: float, least: float, standstill: float) -> float:
    """Smallest width [s] whose first derivative gives the sign of a speed above ``standstill`` [rad/s]."""
    return _narrowed(lambda width: gaussian(width, period, 1), noise, SMALL * standstill, widest, least)


def slope(width: float, period: float, smoothing: float) -> np.ndarray:
    """Kernel of the acceleration, from a speed that a drive has smoothed by a lag [s]."""
    return gaussian(width, period, 1) + smoothing * gaussian(width, period, 2)


def _narrowed(
    kernel: Callable[[float], np.ndarray], noise: float, allowed: float, widest: float, least: float
) -> float:
    """Smallest width [s] whose ``kernel`` leaves at most an ``allowed`` part of the ``noise`` of one sample."""
    width = widest
    while width * NARROWER >= least and noise * float(np.linalg.norm(kernel(width * NARROWER))) <= allowed:
        width *= NARROWER
    return width
