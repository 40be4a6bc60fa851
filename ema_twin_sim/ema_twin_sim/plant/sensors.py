"""The bench's sensors: the plant as seen in the drive's trace, so that residuals compare like with like."""

import math

import numpy as np
from numba import njit

from .layout import ENCODER_MEMORY


@njit(error_model="numpy")
def remember(state, angle):
    """Store the output's angle of this control cycle, for a delayed encoder."""
    newest = (state.encoder_newest + 1) % ENCODER_MEMORY
    state.encoder_newest = newest
    state.encoder_memory[newest] = angle


@njit(error_model="numpy")
def shown(plant, state, angle, since_cycle):
    """Output angle [rad, slow shaft] as its encoder shows it: delayed and with angle error.

    ``angle`` is the true one [rad, fast shaft], ``since_cycle`` [s] the time since the last stored one.
    """
    delay = plant.encoder_delay
    if delay > 0.0:
        newest = state.encoder_newest
        if delay <= since_cycle:
            angle -= (angle - state.encoder_memory[newest]) * (delay / since_cycle)
        else:
            back = (delay - since_cycle) / plant.control_cycle
            whole = min(int(back), ENCODER_MEMORY - 2)
            later = state.encoder_memory[(newest - whole) % ENCODER_MEMORY]
            earlier = state.encoder_memory[(newest - whole - 1) % ENCODER_MEMORY]
            angle = later + (back - whole) * (earlier - later)
    slow = angle / plant.gear_ratio
    error = 0.0
    for k in range(plant.angle_errors):
        order = plant.angle_error[k, 2]
        start = order * state.output_angle_origin + plant.angle_error[k, 1]
        error += plant.angle_error[k, 0] * (math.sin(start + order * slow) - math.sin(start))
    return slow + error


def angle_error(plant: np.void, origin: float, angle: np.ndarray) -> np.ndarray:
    """Error (n,) [rad] of the output encoder at its true ``angle`` (n,), both from zero.

    ``origin`` [rad] is the encoder's own angle at position zero; the plant is a record of ``layout.PLANT``.
    """
    error = np.zeros(len(angle))
    for amplitude, phase, order in plant["angle_error"][: plant["angle_errors"]]:
        start = order * origin + phase
        error += amplitude * (np.sin(start + order * angle) - math.sin(start))
    return error


def as_encoder_shows(plant: np.void, time: np.ndarray, angle: np.ndarray, origin: float) -> np.ndarray:
    """The output's ``angle`` (n,) [rad, slow shaft] over ``time`` (n,) [s] with the encoder's delay and error."""
    if plant["encoder_delay"] != 0.0:
        angle = np.interp(time - plant["encoder_delay"], time, angle)
    return angle + angle_error(plant, origin, angle) if plant["angle_errors"] else angle


@njit(error_model="numpy")
def counted(angle, counts_per_revolution):
    """Angle [rad] as a counter shows it, from zero at the first sample."""
    return math.floor(angle * counts_per_revolution / (2.0 * math.pi) + 0.5) * (2.0 * math.pi / counts_per_revolution)
