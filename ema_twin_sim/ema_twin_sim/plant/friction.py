"""Dry friction that sticks exactly at zero speed, without chatter and without special step sizes."""

import math

from numba import njit

from .compiled import inlined


@njit(error_model="numpy")
def after_dry_friction(free_speed, speed, sliding, break_away):
    """Speed at the end of a step after dry friction.

    ``free_speed`` [rad/s] is the speed without dry friction at the end of the step, ``speed`` that at its start,
    ``sliding`` and ``break_away`` the largest speed changes by friction in this step (level times step over inertia).
    Friction takes the torque that would stop the shaft within the step, limited to its level: at rest the break-away
    level (twice the sliding level in the thesis's "Borello" block), otherwise the sliding one.
    """
    limit = break_away if speed == 0.0 else sliding
    if free_speed > limit:
        return free_speed - sliding
    if free_speed < -limit:
        return free_speed + sliding
    return free_speed - free_speed  # 0, or NaN for a NaN: friction must not turn an error into standstill


@njit(error_model="numpy")
def directed(asymmetry, speed, torque):
    """Factor on friction: 1 + asymmetry forward, 1 - asymmetry backward; at rest by the direction of the torque."""
    forward = speed > 0.0 or (speed == 0.0 and torque > 0.0)
    return 1.0 + asymmetry if forward else 1.0 - asymmetry


@njit(error_model="numpy")
def bristle_share(plant):
    """Share of the bristle on the motor side if the transmission is not rigid.

    Bristles are divided like the dry levels: then they all yield over the same travel, and a rigid transmission is the
    limit of a stiff one.
    """
    total = plant.motor_dry + plant.output_dry
    return plant.motor_dry / total if total > 0.0 else 1.0


@njit(error_model="numpy")
def bristle_step(bent, speed, level, stiffness, damping, step):
    """(bend [rad], torque [N m]) of a bristle after a step: z' = w - stiffness |w| z / level, T = k z + damping z'.

    Implicit in z, so that a stiff bristle allows any step. Canudas de Wit et al. (1995), eqs 1 to 3.
    """
    if level <= 0.0:
        return 0.0, 0.0
    after = (bent + step * speed) / (1.0 + step * stiffness * math.fabs(speed) / level)
    return after, stiffness * after + damping * (after - bent) / step


@inlined
def rubbing(speed, push, asymmetry, viscous, dry, break_away, bristled, bristle, stiffness, damping, step):
    """(uneven torque, bristle's torque, dry level, break-away level [N m], bristle [rad]) of a shaft in a step.

    Asymmetric friction scales the levels, and the asymmetric part of ``viscous`` [N m s/rad] opposes forward motion; at
    rest the torque ``push`` [N m] gives the direction. A bristle replaces both levels.
    """
    uneven = bent = 0.0
    if asymmetry != 0.0:
        factor = directed(asymmetry, speed, push)
        uneven = asymmetry * viscous * math.fabs(speed)
        dry *= factor
        break_away *= factor
    if bristled:
        bristle, bent = bristle_step(bristle, speed, dry, stiffness, damping, step)
        dry = break_away = 0.0
    return uneven, bent, dry, break_away, bristle


@njit(error_model="numpy")
def held_by_dry_friction(torque, level):
    """Remainder [N m] of a torque on a shaft at rest after dry friction."""
    if torque > level:
        return torque - level
    if torque < -level:
        return torque + level
    return 0.0
