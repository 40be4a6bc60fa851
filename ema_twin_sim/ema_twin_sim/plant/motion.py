"""Layout of a measured motion for compiled code."""

MOTION = ("time", "motor_angle", "speed", "acceleration", "current", "output_angle", "load")
"""Columns of a measured motion: s, rad and rad/s and rad/s2 of the fast shaft, A, rad of the slow shaft, N m of a
measured load at the fast shaft; angles count from the recording's first sample."""
TIME, MOTOR_ANGLE, SPEED, ACCELERATION, MOTOR_CURRENT, OUTPUT_ANGLE, LOAD = range(len(MOTION))
