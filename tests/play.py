"""Play, by its definition: an output that friction holds wherever the teeth left it."""

import numpy as np


def behind_play(angle, width):
    """Motion (n,) [rad] of an output behind play of a ``width`` [rad], its motor (at the slow shaft) at ``angle``."""
    held, output = angle[0], np.empty_like(angle)
    for k, driven in enumerate(angle):
        output[k] = held = min(max(held, driven - 0.5 * width), driven + 0.5 * width)
    return output
