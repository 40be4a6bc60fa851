"""How an interval between two samples is divided into equal steps."""

import math

from numba import njit

_ROUNDING = 1e-9  # of a step, by which an interval may be longer than so many whole ones


@njit(error_model="numpy")
def steps_in(interval, longest):
    """How many equal steps of at most ``longest`` [s] an ``interval`` [s] is divided into."""
    return max(1, math.ceil(interval / longest - _ROUNDING))


@njit(error_model="numpy")
def step_in_cycle(control_cycle, longest):
    """The step [s] of at most ``longest`` of which a control cycle takes a whole number: cycles begin on a step."""
    return control_cycle / math.ceil(control_cycle / longest - _ROUNDING)
