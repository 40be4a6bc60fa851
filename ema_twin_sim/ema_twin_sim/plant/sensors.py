"""The bench's sensors: what the drive's trace shows of the plant, so that residuals compare like with like."""

import math

from numba import njit


@njit(error_model="numpy")
def counted(angle, counts_per_revolution):
    """Angle [rad] as a counter shows it, from zero at the first sample."""
    return math.floor(angle * counts_per_revolution / (2.0 * math.pi) + 0.5) * (2.0 * math.pi / counts_per_revolution)
