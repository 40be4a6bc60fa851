"""Division of an interval between two samples into equal steps."""

import math

from numba import njit

_ROUNDING = 1e-9  # share of a step by which an interval may exceed a whole number of steps


@njit(error_model="numpy")
def steps_in(interval, longest):
    """Number of equal steps of at most ``longest`` [s] in an ``interval`` [s]."""
    return max(1, math.ceil(interval / longest - _ROUNDING))


@njit(error_model="numpy")
def step_in_cycle(control_cycle, longest):
    """The step [s] of at most ``longest`` that divides a control cycle evenly, so that cycles begin on a step."""
    return control_cycle / math.ceil(control_cycle / longest - _ROUNDING)
