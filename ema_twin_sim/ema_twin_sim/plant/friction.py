"""Dry friction that holds still exactly at zero speed, without chatter and without a step-size trick."""

from numba import njit


@njit(error_model="numpy")
def after_dry_friction(free_speed, speed, sliding, break_away):
    """Speed at the end of a step once dry friction has taken its share.

    ``free_speed`` [rad/s] is the speed the shaft would reach without dry friction, ``speed`` the one it has,
    ``sliding`` and ``break_away`` what the levels could change it by in this step (level times step over inertia).
    Friction takes the torque that would stop the shaft within the step, and at most its level: the level at rest
    (break-away, twice the sliding level in the thesis's "Borello" block) where the shaft stands, else the sliding one.
    """
    limit = break_away if speed == 0.0 else sliding
    if free_speed > limit:
        return free_speed - sliding
    if free_speed < -limit:
        return free_speed + sliding
    return 0.0


@njit(error_model="numpy")
def held_by_dry_friction(torque, level):
    """What remains [N m] of a torque on a shaft at rest after friction has held what it can."""
    if torque > level:
        return torque - level
    if torque < -level:
        return torque + level
    return 0.0
