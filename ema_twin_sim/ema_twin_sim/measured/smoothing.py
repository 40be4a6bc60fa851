"""Zero-phase smoothing by a Gaussian: short, without ringing, and with exact derivatives.

Both sides of an equation are smoothed by the same kernel, so nothing is lost by it. A Gaussian is short: the effect of
a reversal stays local.
"""

from __future__ import annotations

import numpy as np
from numba import float64, int64, njit, void

from .. import plant  # noqa: F401 (names the folder for what numba compiles)

REACH = 3.5
"""Standard deviations at which a kernel is cut off."""
DERIVATIVE_REACH = 5.0
"""The same for a differentiating kernel, whose tails are heavier. Cut off at 3.5, a second derivative would be 0.7 %
too large and a first one 0.2 %, for a signal that swings by one radian within two standard deviations. Every inertia
would be too small by as much."""


def gaussian(width: float, period: float, derivative: int = 0) -> np.ndarray:
    """Kernel (2 m + 1,) that smooths by a Gaussian of standard deviation ``width`` [s] and differentiates.

    ``derivative`` is 0, 1 or 2, ``period`` [s] the sample period; exact on polynomials up to the second degree.
    """
    half = max(2, int(np.ceil((DERIVATIVE_REACH if derivative else REACH) * width / period)))
    time = np.arange(-half, half + 1) * period
    kernel = np.exp(-0.5 * (time / width) ** 2)
    kernel /= kernel.sum()
    if derivative == 0:
        return kernel
    if derivative == 1:
        slope = time * kernel
        return -slope / float(slope @ time)  # time reversed, because np.convolve flips the kernel
    bend = (time**2 - float(kernel @ time**2)) * kernel
    bend -= bend.mean()
    return bend / (0.5 * float(bend @ time**2))


def smooth(values: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Values (n,) through a kernel; the first and last values are repeated at the ends."""
    half = len(kernel) // 2
    return np.convolve(np.pad(values, half, mode="edge"), kernel, mode="valid")


def smooth_way(way: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Positions (n,) through a kernel; at the ends the motion is continued."""
    half = len(kernel) // 2
    return np.convolve(np.pad(way, half, mode="reflect", reflect_type="odd"), kernel, mode="valid")


@njit(void(float64[:, ::1], float64[::1], int64[::1], float64[:, ::1]), cache=True, nogil=True, error_model="numpy")
def smooth_many_at(values, kernel, centres, smoothed):
    """Like ``smooth_at`` for several columns of ``values`` (n, k) at once: ``smoothed`` (m, k)."""
    half = kernel.shape[0] // 2
    for row in range(centres.shape[0]):
        first = centres[row] - half
        smoothed[row] = 0.0
        for k in range(kernel.shape[0]):
            for m in range(values.shape[1]):
                smoothed[row, m] += kernel[k] * values[first + k, m]


@njit(void(float64[::1], float64[::1], int64[::1], float64[::1]), cache=True, nogil=True, error_model="numpy")
def smooth_at(values, kernel, centres, smoothed):
    """``smoothed`` (m,): values (n,) through a symmetric kernel, only at the samples ``centres`` (m,)."""
    half = kernel.shape[0] // 2
    for row in range(centres.shape[0]):
        first = centres[row] - half
        total = 0.0
        for k in range(kernel.shape[0]):
            total += kernel[k] * values[first + k]
        smoothed[row] = total
