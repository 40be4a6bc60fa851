"""Torque rows that a model requires for the joined motions of several recordings: the compiled part."""

import math

import numpy as np
from numba import boolean, float64, int64, njit, void

from ..measured.smoothing import smooth_at
from ..plant.measured_motion import REQUIRED_TORQUE, inverse_dynamics, inverse_dynamics_of
from ..plant.output_side import LOW_SPEED
from ..plant.signatures import EFFECTS, INDICES, PLANTS, TABLE


@njit(error_model="numpy")
def _fading(kernel_starts, k):
    """Speed [rad/s] below which the direction of recording ``k`` fades; 0 for operating points, whose kernel is 1."""
    return 0.0 if kernel_starts[k + 1] - kernel_starts[k] == 1 else LOW_SPEED


@njit(
    void(
        int64, int64, PLANTS, EFFECTS, TABLE, INDICES, TABLE, float64[::1], INDICES, INDICES, INDICES, float64[::1],
        boolean[::1], boolean, TABLE, float64[::1],
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def require(
    first, end, plant, effects, motion, starts, origins, kernels, kernel_starts, rows, row_starts, seen, has_seen,
    reuse_output_motion, required, torque,
):  # fmt: skip
    """Fill ``required`` and the smoothed ``torque`` of the recordings from ``first`` to ``end``.

    For the arguments see ``JoinedMotions.require``.
    """
    for k in range(first, end):
        begin, stop = starts[k], starts[k + 1]
        position = seen[begin:stop] if has_seen[k] else seen[:0]
        inverse_dynamics(
            plant, effects, motion[begin:stop], origins[k, 0], origins[k, 1], position, reuse_output_motion,
            _fading(kernel_starts, k), required[begin:stop],
        )  # fmt: skip
        smooth_at(
            required[begin:stop, REQUIRED_TORQUE].copy(),
            kernels[kernel_starts[k] : kernel_starts[k + 1]],
            rows[row_starts[k] : row_starts[k + 1]],
            torque[row_starts[k] : row_starts[k + 1]],
        )


@njit(
    float64(
        PLANTS, int64, int64, float64[::1], TABLE, INDICES, TABLE, float64[::1], INDICES, INDICES, INDICES, TABLE,
        float64[::1],
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def require_of(
    plant, address, place, slots, motion, starts, origins, kernels, kernel_starts, rows, row_starts, required, torque
):
    """Fill the smoothed ``torque`` that one effect alone needs; returns the smallest value of the effect.

    For the arguments see ``JoinedMotions.require_of``.
    """
    least = math.inf
    for k in range(starts.shape[0] - 1):
        begin, stop = starts[k], starts[k + 1]
        alone = np.empty(stop - begin)
        value = inverse_dynamics_of(
            plant, address, place, slots, motion[begin:stop], origins[k, 0], origins[k, 1], _fading(kernel_starts, k),
            required[begin:stop], alone,
        )  # fmt: skip
        least = min(least, value)
        smooth_at(
            alone,
            kernels[kernel_starts[k] : kernel_starts[k + 1]],
            rows[row_starts[k] : row_starts[k + 1]],
            torque[row_starts[k] : row_starts[k + 1]],
        )
    return least
