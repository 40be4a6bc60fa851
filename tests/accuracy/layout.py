"""What the other plant is made of: its constants as one record, and its harmonics as rows of a table."""

import numpy as np

STEP_NS = 15_625
"""ns: 128 steps a trace period of 2 ms, 4 or 16 a control cycle of 62.5 or 250 us."""
STEP = STEP_NS * 1e-9

# What a row of the table of harmonics does; its columns are amplitude, order, phase, action.
HARMONIC_COLUMNS = 4
ON_MOTOR = 0.0  # torque at the motor counter's angle
ON_MOTOR_LEVEL = 1.0  # dry level at the motor counter's angle
ON_MOTOR_TORQUE = 2.0  # share of the motor's own torque, at the motor counter's angle
ON_OUTPUT = 3.0  # torque on the output at the output encoder's angle
ON_OUTPUT_LEVEL = 4.0  # dry level of the output at the output encoder's angle

BURST_COLUMNS = 3
"""Columns of the table of bursts: start [s], end [s], dry level [N m]; by rising start, none overlapping."""

STRIBECK_LAWS = ("exponential", "gaussian", "lorentzian")
SMOOTH_LAWS = ("tanh", "arctangent", "root")
"""Their numbers in the record are their places here."""

PLANT = np.dtype(
    [
        (name, np.float64)
        for name in (
            # machine; torques, inertias and angles at the fast shaft
            "ratio",
            "motor_inertia",
            "output_inertia",
            "torque_constant",  # N m/A, the true one
            "believed_torque_constant",  # N m/A, the drive's
            "back_emf",  # V s/rad
            "resistance",  # ohm
            "inductance",  # H
            # transmission
            "stiffness",  # N m/rad
            "damping",  # N m s/rad
            "half_gap",  # rad
            "load_share",  # share of the output's inertia that hangs behind a coupling, beyond the encoder
            "load_stiffness",  # N m/rad
            "load_damping",  # N m s/rad
            # friction
            *("motor_viscous", "output_viscous", "motor_level", "output_level"),
            "bristle_stiffness",  # N m/rad, of both sides together
            "bristle_damping",  # N m s/rad
            "elastic_share",  # share of the bristle's travel that springs back wholly; below 0: a plain LuGre bristle
            *("stribeck_level", "stribeck_speed", "stribeck_law"),
            "smooth_speed",  # rad/s over which dry friction builds up; 0: it is there at once
            "smooth_law",
            *("asymmetry", "mesh_coefficient"),
            "drag",  # N m s2/rad2
            *("thinning", "thinning_speed", "warming", "warming_time"),
            *("bump_level", "bump_speed", "bump_width"),  # a friction resonance: more dry level around one speed
            # friction's slow change: relative amplitude, two periods [s], two phases
            *("wander", "wander_period", "wander_phase", "wander_period_2", "wander_phase_2"),
            # loads
            "constant_load",
            "spring",  # N m per rad of the slow shaft
            "pulse",  # N m, a damaged tooth
            *("pulse_order", "pulse_position"),
            "pulse_width",  # rad of the tooth's own turn, the whole of it
            "pulse_is_level",
            # encoders
            "delay",  # s
            "eccentricity",  # rad, slow shaft
            "eccentricity_phase",
            "interpolation",  # rad, slow shaft: error within each line of the output encoder
            "interpolation_lines",  # lines a revolution
            "motor_origin",  # rad: what the counters show at the start
            "output_origin",
            # drive
            *("position_gain", "speed_limit"),
            "filter",  # s
            *("speed_gain", "integral_time", "integral_limit", "dead_band", "anti_windup", "torque_limit"),
            "current_lag",
            "smoothing",  # s, of the shown speed
        )
    ]
)

TRACE = ("current", "current_setpoint", "speed", "speed_setpoint", "motor_position", "output_position", "voltage")
"""Columns that the plant writes: true values in SI units, before noise and counting."""
