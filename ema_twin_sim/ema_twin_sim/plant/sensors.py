"""The bench's sensors: what the drive's trace shows of the plant, so that residuals compare like with like."""

import math

from numba import njit

from .layout import ENCODER_MEMORY


@njit(error_model="numpy")
def remember(state, angle):
    """Keep the output's angle of this control cycle, for an encoder that answers late."""
    newest = (state.encoder_newest + 1) % ENCODER_MEMORY
    state.encoder_newest = newest
    state.encoder_memory[newest] = angle


@njit(error_model="numpy")
def shown(plant, state, angle, since_cycle):
    """Output angle [rad, slow shaft] as its encoder shows it: late, and off its centre.

    ``angle`` is the true one [rad, fast shaft], ``since_cycle`` [s] the time since the last one that was remembered.
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
    if plant.eccentricity_amplitude != 0.0:
        start = state.output_angle_origin + plant.eccentricity_phase
        slow += plant.eccentricity_amplitude * (math.sin(start + slow) - math.sin(start))
    return slow


@njit(error_model="numpy")
def counted(angle, counts_per_revolution):
    """Angle [rad] as a counter shows it, from zero at the first sample."""
    return math.floor(angle * counts_per_revolution / (2.0 * math.pi) + 0.5) * (2.0 * math.pi / counts_per_revolution)
