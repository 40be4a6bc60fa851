"""One sample of a twin, as seen by the bench's sensors."""

import math

from .compiled import inlined
from .layout import (
    COMMAND_IN,
    COMMAND_OUT,
    CURRENT_IN,
    CURRENT_OUT,
    CURRENT_SETPOINT_OUT,
    DIRECT_CURRENT_OUT,
    LOAD_TORQUE_OUT,
    MOTOR_POSITION_OUT,
    MOTOR_TORQUE_OUT,
    OUTPUT_POSITION_OUT,
    PHASE_U_OUT,
    PHASE_V_OUT,
    PHASE_W_OUT,
    SETPOINT_OUT,
    SPEED_OUT,
    UNEXPLAINED_OUT,
    VOLTAGE_OUT,
)
from .sensors import counted, shown


@inlined
def write_row(
    row, bench, by_current, plant, state, phase, angle, output_angle, smoothed, setpoint, current, current_setpoint,
    voltage, torque, transmitted,
):  # fmt: skip
    """Fill a twin's sample ``row`` (signals,) for the bench's (6,); signals unknown to an averaged drive are NaN.

    ``phase`` [s] is the time since the last control cycle began; ``by_current``: the measured current drives the twin.
    """
    row[CURRENT_OUT] = bench[CURRENT_IN] if by_current else current
    row[CURRENT_SETPOINT_OUT] = math.nan if by_current else current_setpoint
    row[SPEED_OUT] = smoothed
    row[SETPOINT_OUT] = math.nan if by_current else setpoint
    row[MOTOR_POSITION_OUT] = counted(angle, plant.motor_counts)
    row[OUTPUT_POSITION_OUT] = counted(
        shown(plant, state, output_angle, phase) - state.encoder_zero, plant.output_counts
    )
    row[COMMAND_OUT] = bench[COMMAND_IN]
    row[VOLTAGE_OUT] = voltage
    row[MOTOR_TORQUE_OUT] = torque
    row[LOAD_TORQUE_OUT] = transmitted
    row[UNEXPLAINED_OUT] = math.nan
    row[DIRECT_CURRENT_OUT] = math.nan
    row[PHASE_U_OUT] = math.nan
    row[PHASE_V_OUT] = math.nan
    row[PHASE_W_OUT] = math.nan
