"""Check torque constants from data sheets by the voltage that a motor with them would induce: at which shaft they are
given, and whether they are possible at all.
"""

from __future__ import annotations

import math

from ema_bench_replay.errors import InputError
from ema_bench_replay.units import unit_in

from ..criteria import TOO_MUCH
from .shaft import GEARED

BUS = 600.0
"""V that a motor may induce: about the DC link of a drive at a mains of 400 V, as most servo drives are (565 V,
rectified). Drives of small motors and robots have 24 to 325 V."""
RATED_SPEED = 1000.0 * 2.0 * math.pi / 60.0
"""rad/s, the lowest rated speed of motors behind a gear."""


def told_at_joint(torque_constant: float | None, gear_ratio: float, motor_speed: float) -> str:
    """Why a torque per ampere [N m/A] must be that of the joint, including the gear; empty if it may be the motor's.

    A motor with k N m/A induces k V s/rad: at ``motor_speed`` [rad/s] that would be more than any drive's bus has.
    """
    if torque_constant is None or gear_ratio < GEARED or torque_constant * motor_speed <= BUS:
        return ""
    return (
        f"a motor of {torque_constant:g} N m/A would induce {torque_constant * motor_speed:.0f} V at its "
        f"{motor_speed:.3g} rad/s; a drive has {BUS:g} V"
    )


def question_about(
    torque_constant: float | None, gear_ratio: float, motor_speed: float, *, at_joint: bool, motion: str
) -> str:
    """A question about a torque constant [N m/A, N/A] that hardly any motor has; empty if there is none.

    ``motor_speed`` [rad/s, m/s] is the highest that was recorded; a constant ``at_joint`` includes the gear ratio.
    Raises InputError if no motor has it.
    """
    if torque_constant is None:
        return ""
    motors = torque_constant / (gear_ratio if at_joint else 1.0)
    speed = max(motor_speed, RATED_SPEED if gear_ratio >= GEARED else 0.0)
    if motors * speed <= BUS:
        return ""
    unit = unit_in("N m/A", motion)
    shown = f"{torque_constant:g} {unit}" + (f" at the joint, {motors:.3g} {unit} at the motor," if at_joint else "")
    why = (
        f"--torque-constant: a motor of {shown} would induce {motors * speed:.0f} V at "
        f"{speed:.3g} {unit_in('rad/s', motion)}, where a drive has {BUS:g} V"
    )
    other = f"if it is in m{unit}, give {torque_constant / 1000.0:g}"
    if gear_ratio < GEARED and motion == "rotary":
        other += "; if it is given at the output of a gear, give --gear-ratio"
    if motors * speed > TOO_MUCH * BUS:
        raise InputError(f"{why}; {other}")
    return f"{why}: is that right? {other[:1].upper()}{other[1:]}"
