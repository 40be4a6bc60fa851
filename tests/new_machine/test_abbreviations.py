"""Sensors beside the motor's: those named as the motor's are taken."""

import numpy as np
import pytest

from tests.taken_columns import taken

TIME = np.arange(400) * 2e-3
SPEED = 2.0 * np.cos(3.0 * TIME)


@pytest.mark.parametrize("other", ["imu velocity [rad/s]", "gyro_z [rad/s]", "angular velocity [rad/s]"])
def test_the_speed_named_as_the_motors_is_taken(other):
    columns = {"time [s]": TIME, other: 0.3 * SPEED, "motor velocity [rad/s]": SPEED, "current [A]": np.sign(SPEED)}
    assert taken(columns)["speed"] == "motor velocity [rad/s]"


def test_an_inertial_sensor_comes_after_an_unnamed_shaft():
    columns = {"time [s]": TIME, "imu actual velocity [rad/s]": 0.3 * SPEED, "velocity [rad/s]": SPEED}
    assert taken(columns)["speed"] == "velocity [rad/s]"
    angles = {"imu angle [deg]": 500.0 * np.sin(3.0 * TIME), "angle [deg]": 40.0 * np.sin(3.0 * TIME + 1.0)}
    assert taken({"time [s]": TIME, **angles})["motor_position"] == "angle [deg]"


def test_the_motors_current_goes_before_the_supplys():
    columns = {"time [s]": TIME, "battery current [A]": SPEED, "I [A]": np.sign(SPEED)}
    assert taken(columns)["current"] == "I [A]"
