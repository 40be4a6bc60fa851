"""Sum of all effects at an operating point."""

from numba import njit

from .layout import DRY_LEVEL, OUTPUT_TORQUE, TORQUE
from .operating_point import call_effect, changed


@njit(error_model="numpy")
def evaluate(effects, at):
    """Sums of the effects at an operating point: torque on the motor, dry level, torque on the output [N m], and change
    of the viscous coefficient [N m s/rad]. The torque of that change is included in the first.
    """
    addresses, places, p = effects
    torque = 0.0
    dry = at.dry_level
    output_torque = 0.0
    viscous = 0.0
    for k in range(addresses.shape[0]):
        point = changed(at, at.transmitted_torque, dry)
        value = call_effect(addresses[k], point, (p[k, 0], p[k, 1], p[k, 2], p[k, 3]))
        if places[k] == TORQUE:
            torque += value
        elif places[k] == DRY_LEVEL:
            dry += value
        elif places[k] == OUTPUT_TORQUE:
            output_torque += value
        else:  # VISCOUS_COEFFICIENT
            viscous += value
            torque += value * at.motor_speed
    return torque, (0.0 if dry < 0.0 else dry), output_torque, viscous
