"""A motor's torque constant: from its data sheet, or from a torque that the drive computed of the recorded current.

It is checked by the voltage that a motor with it would induce: at which shaft it is given, and whether it is possible
at all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_bench_replay.units import unit_in

from ..criteria import NEGLIGIBLE, SMALL, TOO_MUCH
from ..measured.induced_voltage import BUS
from ..model.check_comment import ASSUMED, REMEDIES
from ..model.constants import CONSTANTS
from ..model.model_file import TORQUE_CONSTANT
from .shaft import GEARED
from .torque_beside_current import proportion

GIVEN = "given"
"""The source of what the user said, or its beginning."""

TORQUE_OVER_CURRENT = "torque over current of the recording"
"""The source of a torque constant that two columns show."""

AT_OUTPUT = "if it is given at the output of a gear, give --gear-ratio"

RATED_SPEED = 1000.0 * 2.0 * math.pi / 60.0
"""rad/s, the lowest rated speed of motors behind a gear."""


class TorqueConstant(NamedTuple):
    """A torque constant [N m/A, N/A], its source, and what is doubtful about it."""

    value: float
    source: str
    doubt: str = ""


def torque_constant(given: float | None, recordings: Sequence[Recording]) -> TorqueConstant:
    """The torque constant: as given, else as torque over current, else 1.

    The ``recordings`` are at the motor's shaft. A drive computes its torque from its current, so that both are one
    thing in two units. Where more of the torque is left, it tells nothing.
    """
    if given:
        return TorqueConstant(given, GIVEN)
    found, bounds = proportion(recordings), CONSTANTS[TORQUE_CONSTANT]
    if found is None or found.left > SMALL or not bounds.lower <= abs(found.factor) <= bounds.upper:
        return TorqueConstant(1.0, ASSUMED, REMEDIES[TORQUE_CONSTANT])
    doubts = [f"{100.0 * found.left:.0f} % of the torque's changes is left"] * (found.left > NEGLIGIBLE)
    doubts += ["both have opposite signs"] * (found.factor < 0.0)
    doubt = f"{TORQUE_OVER_CURRENT}, but {' and '.join(doubts)}: compare with the motor's data sheet" if doubts else ""
    return TorqueConstant(abs(found.factor), TORQUE_OVER_CURRENT, doubt)


def told_at_joint(torque_constant: float, gear_ratio: float, motor_speed: float) -> str:
    """Why a torque per ampere [N m/A] must be that of the joint, including the gear; empty if it may be the motor's.

    A motor with k N m/A induces k V s/rad: at ``motor_speed`` [rad/s] that would be more than any drive's bus has.
    """
    if gear_ratio < GEARED or torque_constant * motor_speed <= BUS:
        return ""
    return (
        f"a motor of {torque_constant:g} N m/A would induce {torque_constant * motor_speed:.0f} V at its "
        f"{motor_speed:.3g} rad/s; a drive has {BUS:g} V"
    )


def question_about(
    torque_constant: float | None,
    gear_ratio: float,
    motor_speed: float,
    *,
    at_joint: bool,
    motion: str,
    if_turning: str = AT_OUTPUT,
) -> str:
    """A question about a torque constant [N m/A, N/A] that hardly any motor has; empty if there is none.

    ``motor_speed`` [rad/s, m/s] is the highest that was recorded; a constant ``at_joint`` includes the gear ratio.
    ``if_turning`` tells what else may be wrong of a motor that turns without a gear.
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
        other += f"; {if_turning}"
    if motors * speed > TOO_MUCH * BUS:
        raise InputError(f"{why}; {other}")
    return f"{why}: is that right? {other[:1].upper()}{other[1:]}"
