"""How loggers abbreviate quantities, with the number or the side of their part; and sensors beside the motor's."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.columns import guess_columns
from tests.taken_columns import taken

TIME = np.arange(400) * 2e-3
SPEED = 2.0 * np.cos(3.0 * TIME)


def signals(*header):
    return {guess.column: guess.signal for guess in guess_columns(header).signals}


@pytest.mark.parametrize(
    ("names", "signal"),
    [
        ("CURR CURR_M1 currLeft MotCurr motor_curr AMPS_1 iq i_q iq1 Strm", "current"),
        ("VEL vel1 spdR SPD_left velLeft", "speed"),
        ("POS pos1 posR POS_left curr_pos Current_Position cur_pos_1", "motor_position"),
        ("trq TRQ1 trqLeft tau1 tauR TQ_1 tq_left tor MotorFbTor ActTor tor_fb", "motor_torque"),
        ("curr_vel CurrentSpeed", "speed"),
    ],
)
def test_abbreviations_are_known(names, signal):
    for name in names.split():
        assert signals("t", name) == {name: signal}


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
