"""The plant's constants and state as records, so that compiled code reads them by name."""

from __future__ import annotations

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from ema_bench_replay.units import SIGNALS

ANGLE_ERRORS = 8
"""Maximum waves in the output encoder's error: a resolver has orders 1, 2 and its pole pairs."""

PLANT = np.dtype(
    [
        # machine
        ("gear_ratio", "f8"),  # fast shaft turns per slow shaft turn
        ("motor_inertia", "f8"),  # kg m2, motor and gearbox
        ("output_inertia", "f8"),  # kg m2, reduced to the fast shaft
        ("torque_constant", "f8"),  # N m/A, of the machine
        ("back_emf_constant", "f8"),  # V s/rad, per phase
        ("phase_resistance", "f8"),  # ohm
        ("phase_inductance", "f8"),  # H
        ("pole_pairs", "f8"),  # NaN if unknown
        # drive
        ("nominal_torque_constant", "f8"),  # N m/A, assumed by the drive
        ("position_gain", "f8"),  # 1/s of the fast shaft per rad of the slow shaft
        ("speed_limit", "f8"),  # rad/s
        ("speed_setpoint_filter", "f8"),  # s
        ("speed_gain", "f8"),  # N m s/rad
        ("integral_time", "f8"),  # s
        ("integral_limit", "f8"),  # N m
        ("integral_dead_band", "f8"),  # rad of the fast shaft
        ("anti_windup_time", "f8"),  # s
        ("torque_limit", "f8"),  # N m
        ("current_limit", "f8"),  # A
        ("control_cycle", "f8"),  # s
        ("current_lag", "f8"),  # s
        # friction: parts independent of the operating point are summed once, not in every step
        ("motor_viscous", "f8"),  # N m s/rad
        ("output_viscous", "f8"),  # N m s/rad, at the fast shaft
        ("motor_dry", "f8"),  # N m, sliding
        ("output_dry", "f8"),
        ("motor_break_away", "f8"),  # N m, at rest
        ("output_break_away", "f8"),
        ("asymmetry", "f8"),  # all friction is (1 + asymmetry) forward, (1 - asymmetry) backward
        ("bristle_stiffness", "f8"),  # N m/rad; above zero a bristle replaces the motor side's dry friction
        ("bristle_damping", "f8"),  # N m s/rad
        # transmission
        ("two_inertia", "f8"),  # 0 rigid, 1 spring, damper and dead zone between motor and output
        ("contact_stiffness", "f8"),  # N m/rad at the fast shaft
        ("contact_damping", "f8"),  # N m s/rad at the fast shaft
        ("gap", "f8"),  # rad, half the dead zone at the fast shaft
        ("end_stop_lower", "f8"),  # rad of the slow shaft
        ("end_stop_upper", "f8"),
        # sensors
        ("motor_counts", "f8"),  # 1/rev of the fast shaft
        ("motor_dither", "f8"),  # rad by which rounding and noise move the motor's counter at rest
        ("output_counts", "f8"),  # 1/rev of the slow shaft
        ("encoder_delay", "f8"),  # s
        ("angle_errors", "i8"),  # number of waves in angle_error of the output encoder
        ("angle_error", "f8", (ANGLE_ERRORS, 3)),  # amplitude [rad, slow shaft], phase [rad], order
        ("speed_smoothing", "f8"),  # s
    ],
    align=True,
)

ENCODER_MEMORY = 256
"""Control cycles stored by the output encoder: 32 ms at the usual 125 us."""

STATE = np.dtype(
    [
        ("time", "f8"),  # s since the first sample
        ("motor_angle", "f8"),  # rad since the first sample
        ("motor_speed", "f8"),
        ("output_angle", "f8"),  # rad of the fast shaft (slow shaft times the gear ratio) since the first sample
        ("output_speed", "f8"),  # rad/s of the fast shaft
        ("twist", "f8"),  # rad of the fast shaft, difference of motor and output while the transmission is rigid
        ("current", "f8"),
        ("current_setpoint", "f8"),
        ("integral", "f8"),  # N m, the speed controller's integrator
        ("speed_setpoint", "f8"),  # rad/s, after its filter
        ("smoothed_speed", "f8"),  # rad/s, as the drive reports it
        ("control_phase", "f8"),  # s since the last control cycle
        ("acceleration", "f8"),  # rad/s2
        ("transmitted_torque", "f8"),  # N m
        ("bristle", "f8"),  # rad, deflection of the bristle of presliding friction
        ("output_bristle", "f8"),  # rad of the fast shaft, the same on the output side
        ("encoder_memory", "f8", (ENCODER_MEMORY,)),  # rad of the fast shaft, the output at past control cycles
        ("encoder_zero", "f8"),  # rad of the slow shaft, encoder reading at the first sample
        ("encoder_newest", "i8"),  # index of the newest entry
        ("output_start", "f8"),  # rad of the fast shaft, output_angle at the first sample (position zero)
        ("motor_angle_origin", "f8"),  # rad, the counter's angle at motor_angle zero
        ("output_angle_origin", "f8"),  # rad of the slow shaft, the encoder's angle at output_angle zero
        # the filters of the unexplained torque (see balance.py)
        ("balance_torque_in", "f8"),
        ("balance_torque_1", "f8"),
        ("balance_torque_2", "f8"),
        ("balance_torque_3", "f8"),
        ("balance_torque_late", "f8"),
        ("balance_dry_late", "f8"),
        ("balance_speed_1", "f8"),
        ("balance_speed_2", "f8"),
        ("balance_ready", "f8"),
        ("balance_direction", "f8"),  # -1 or 1, in which the motor's counter moves
        ("balance_farthest", "f8"),  # rad, how far it has come in that direction
        ("balance_since", "f8"),  # s since it was there
        ("balance_sense", "f8"),  # -1 to 1, the direction after the first lag
        # the output driven by the measured motion (see driven_output.py), angles and speeds at the fast shaft
        ("driven_motor_angle", "f8"),
        ("driven_motor_speed", "f8"),
        ("driven_output_angle", "f8"),
        ("driven_output_speed", "f8"),
        ("driven_ready", "f8"),
        ("driven_bristle", "f8"),  # rad, the bristle under the measured motion
        ("driven_output_bristle", "f8"),
    ],
    align=True,
)

INPUTS = ("standalone", "standalone_speed", "setpoint", "current")
"""Inputs that drive the twin; an input's number is its index here."""
STANDALONE, STANDALONE_SPEED, SETPOINT, CURRENT = range(4)

BENCH = ("output_command", "speed_setpoint", "current", "speed", "motor_position", "load_torque")
"""Columns of a bench sample that the kernel reads; the last is a measured external load [N m at the fast shaft] on the
output."""
COMMAND_IN, SETPOINT_IN, CURRENT_IN, SPEED_IN, MOTOR_POSITION_IN, LOAD_IN = range(6)

TWIN = tuple(name for name in SIGNALS if name != "temperature")
"""Columns of a twin sample: the bench's signals, through the same sensors (no twin computes the temperature). Those
that ``row.py`` does not write stay NaN."""
OUT: Any = namedtuple("OUT", TWIN)(*range(len(TWIN)))
"""The column of each signal: ``OUT.current``."""

TORQUE, DRY_LEVEL, OUTPUT_TORQUE, VISCOUS_COEFFICIENT = range(4)
"""Target of an effect's value: a torque on the motor, a dry friction level on the motor, a torque on the output, a
viscous coefficient of the motor (levels and coefficients are summed before asymmetry scales all friction)."""


Effects = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Addresses (n,), targets (n,) and parameters (n, 4) of effects that depend on the operating point."""


class Fine(NamedTuple):
    """Kernel inputs of the finer fidelities; parts that a model lacks are never used."""

    windings: np.ndarray
    """(1,) of ``switching.layout.WINDING``"""
    winding_states: np.ndarray
    """(1,) of ``switching.layout.WINDING_STATE``"""
    trains: np.ndarray
    """(1,) of ``planetary.layout.TRAIN``"""
    train_states: np.ndarray
    """(1,) of ``planetary.layout.TRAIN_STATE``"""
    lanes: np.ndarray
    """the planets, and the last state of the meshes (``planetary.layout.ROW``)"""
    mesh_table: np.ndarray
    """(3, points + 1, 4) of ``planetary.mesh_table``"""
    energies: np.ndarray
    """[J], of ``energy.ENERGIES``"""
