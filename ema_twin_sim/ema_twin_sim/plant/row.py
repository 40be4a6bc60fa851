"""One sample of a twin, as seen by the bench's sensors."""

import math
from typing import NamedTuple

from .compiled import inlined
from .layout import COMMAND_IN, CURRENT_IN, OUT
from .sensors import counted, shown


class Moment(NamedTuple):
    """What a loop knows of the twin at a sample, in SI; at the fast shaft unless its field says otherwise."""

    phase: float
    """s since the last control cycle began"""
    angle: float
    speed: float
    acceleration: float
    output_angle: float
    smoothed_speed: float
    speed_setpoint: float
    current: float
    current_setpoint: float
    voltage: float
    torque: float
    """of the motor"""
    transmitted: float
    """torque"""


@inlined
def write_row(row, bench, by_current, plant, state, at):
    """Fill a twin's sample ``row`` (signals,) at a ``Moment`` for the bench's (6,).

    ``by_current``: the measured current drives the twin.
    """
    write_signals(
        row, bench, by_current, at, counted(at.angle, plant.motor_counts),
        counted(shown(plant, state, at.output_angle, at.phase) - state.encoder_zero, plant.output_counts),
    )  # fmt: skip


@inlined
def write_signals(row, bench, by_current, at, motor_position, output_position):
    """As ``write_row``, with the positions as the encoders show them; signals unknown to an averaged drive are NaN."""
    row[OUT.current] = bench[CURRENT_IN] if by_current else at.current
    row[OUT.current_setpoint] = math.nan if by_current else at.current_setpoint
    row[OUT.speed] = at.smoothed_speed
    row[OUT.speed_setpoint] = math.nan if by_current else at.speed_setpoint
    row[OUT.motor_position] = motor_position
    row[OUT.output_position] = output_position
    row[OUT.output_command] = bench[COMMAND_IN]
    row[OUT.voltage] = at.voltage
    row[OUT.motor_torque] = at.torque
    row[OUT.load_torque] = at.transmitted
    row[OUT.unexplained_torque] = math.nan
    row[OUT.direct_current] = math.nan
    row[OUT.phase_current_u] = math.nan
    row[OUT.phase_current_v] = math.nan
    row[OUT.phase_current_w] = math.nan
