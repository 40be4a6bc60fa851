"""The resolver: the rotor angle assumed by the drive."""

import math

from ..compiled import compiled


@compiled
def resolver_error(constants, angle):
    """Error [rad] of the resolver at a true motor angle [rad].

    An offset (the resolver was not aligned with the rotor axis) and a sinusoidal error over the turn (eccentricity:
    order 1; unequal windings: twice its pole pairs). The pole pairs multiply it: 1 deg of the shaft is 4 deg
    electrical.
    """
    return constants.resolver_offset + constants.resolver_amplitude * math.sin(
        constants.resolver_order * angle + constants.resolver_phase
    )
