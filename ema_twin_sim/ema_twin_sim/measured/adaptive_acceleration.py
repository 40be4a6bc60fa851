"""Acceleration that is smoothed at each row as widely as its noise cannot tell from smoothing it less.

A regression on a noisy acceleration finds the inertia too small, by the noise's share in what the model's other terms
do not explain of it (errors in variables: Fuller, Measurement Error Models, 1987). In a sine of one frequency these
explain nearly all, since a load that follows the position looks the same. Teeth and impacts need a narrow kernel for
the torque, but the acceleration between them needs none.

The width is chosen by intersecting confidence intervals (Goldenshluger and Nemirovski, Mathematical Methods of
Statistics 6, 1997). A difference of two Gaussians, twice one less one that is wider by the root of two, has no error of
second order: a single one would make a slow acceleration too small, and so the inertia too large.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from .smoothing import smooth_at

_TIMES = (2.0, 4.0, 8.0)  # widths, over the usual one
_AGREE = 3.0  # standard deviations of the narrower one's noise within which two accelerations agree


def adaptive_acceleration(
    acceleration: np.ndarray,
    rows: np.ndarray,
    noise: float,
    width: float,
    differentiate: Callable[[float], tuple[np.ndarray, np.ndarray, float]],
    corners: np.ndarray,
) -> np.ndarray:
    """Acceleration (m,) [rad/s2] at ``rows`` (m,) of what is known through a kernel of ``width`` [s] (m,).

    ``noise`` [rad/s2] is what the sensor leaves in it, ``differentiate`` the ``differentiator`` of the signals as a
    function of the width. No wide kernel covers ``corners`` (n,): samples where friction may hold and release the
    machine, and gaps.
    """
    chosen = acceleration.copy()
    narrower = [(acceleration, noise)]
    wider = np.ones(len(rows), bool)  # rows whose last width agreed with all narrower ones
    corners_before = np.concatenate([[0], np.cumsum(corners)])  # number of them before each sample
    for times in _TIMES:
        signal, kernel, noise = _to_third_order(differentiate, times * width)
        half = len(kernel) // 2
        wider &= (rows >= half) & (rows < len(signal) - half)
        first, end = np.maximum(rows - half // 2, 0), np.minimum(rows + half // 2 + 1, len(signal))
        wider &= corners_before[end] == corners_before[first]  # its outer half has almost no weight
        places = np.flatnonzero(wider)
        found = np.empty(len(places))
        smooth_at(np.ascontiguousarray(signal), kernel[::-1].copy(), rows[places], found)
        agrees = np.ones(len(places), bool)
        for values, deviation in narrower:
            agrees &= np.abs(found - values[places]) <= _AGREE * deviation
        chosen[places[agrees]] = found[agrees]
        wider[places[~agrees]] = False
        whole = np.full(len(rows), np.nan)
        whole[places] = found
        narrower.append((whole, noise))
    return chosen


def _to_third_order(
    differentiate: Callable[[float], tuple[np.ndarray, np.ndarray, float]], width: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """As ``differentiate``, without an error of second order."""
    signal, once, noise = differentiate(width)
    _, wider, _ = differentiate(math.sqrt(2.0) * width)
    kernel = -wider
    beyond = len(kernel) // 2 - len(once) // 2
    kernel[beyond : len(kernel) - beyond] += 2.0 * once
    return signal, kernel, noise * float(np.linalg.norm(kernel) / np.linalg.norm(once))
