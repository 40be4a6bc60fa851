"""The resolver: where the drive believes the rotor is."""

import math

from ..compiled import compiled


@compiled
def resolver_error(constants, angle):
    """Error [rad] of the motor angle that the resolver shows, at a true one [rad].

    An offset (the resolver was not set to the rotor's axis) and a wave over the turn (its own eccentricity: order 1;
    unequal windings: twice its pole pairs). The pole pairs multiply it: 1 deg of the shaft is 4 deg electrical.
    """
    return constants.resolver_offset + constants.resolver_amplitude * math.sin(
        constants.resolver_order * angle + constants.resolver_phase
    )
