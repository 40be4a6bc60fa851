"""A controller's error is neither the motor's position nor its speed, whether its name says so or only its numbers."""

import numpy as np
import pytest

from tests.taken_columns import taken

TIME = np.arange(800) * 2e-3
ANGLE = np.sin(3.0 * TIME)
SPEED = 3.0 * np.cos(3.0 * TIME)
CURRENT = np.sign(SPEED) - 0.5 * ANGLE
ERROR = 0.02 * np.cos(3.0 * TIME)


def logged(**more):
    """A joint's columns, of which none is named as the motor's."""
    columns = {"t [s]": TIME, "joint position [rad]": ANGLE, "joint velocity [rad/s]": SPEED, "i [A]": CURRENT}
    return {**columns, **more}


@pytest.mark.parametrize("name", ["{}Err", "{}_err", "{}_ERROR", "{}err"])
def test_errors_by_name_are_no_signals(name, drafted):
    errors = {f"{name.format('vel')} [rad/s]": 3.0 * ERROR, f"{name.format('pos')} [rad]": -ERROR}
    found = taken(logged(**errors))
    assert found["motor_position"] == "joint position [rad]" and found["speed"] == "joint velocity [rad/s]"
    assert "output_position" not in found
    assert "say so in its name" not in drafted(logged(**errors)).said


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_command_minus_what_is_measured_is_an_error_whatever_its_name(sign, drafted):
    columns = logged(**{"e_q angle [rad]": sign * ERROR, "angle command [rad]": ANGLE + ERROR})
    assert taken(columns)["motor_position"] == "joint position [rad]"
    said = drafted(columns).said
    assert "e_q angle [rad]: not used, since it is angle command [rad] minus joint position [rad]: a control" in said


def test_positions_that_are_no_difference_are_used():
    columns = logged(**{"motor position [rad]": 50.0 * ANGLE, "angle command [rad]": ANGLE + ERROR})
    found = taken(columns)
    assert found["motor_position"] == "motor position [rad]" and found["output_position"] == "joint position [rad]"


def test_what_follows_the_command_behind_a_gear_of_two_is_used():
    columns = logged(**{"motor position [rad]": 2.0 * ANGLE, "angle command [rad]": ANGLE})
    assert taken(columns)["output_position"] == "joint position [rad]"


def test_a_share_of_a_torque_comes_after_the_whole():
    columns = logged(**{"torKdEst [N m]": 1e5 * SPEED, "torEst [N m]": CURRENT + ANGLE})
    assert taken(columns)["motor_torque"] == "torEst [N m]"


def test_a_torque_that_drives_never_have_is_asked_about(drafted):
    columns = {"t [s]": TIME, "motor position [rad]": ANGLE, "motor torque [N m]": 281806.0 * CURRENT}
    assert "motor_torque reaches" in drafted(columns).warned
    assert "in mN m, and read as N m?" in drafted(columns).warned
    assert "motor_torque reaches" not in drafted({**columns, "motor torque [N m]": 300.0 * CURRENT}).warned
