"""A torque beside a current in a table of operating points may be a dynamometer's: `init` asks."""

import numpy as np
import pytest

SPEED = np.linspace(0.0, 5600.0, 60)
TORQUE = 3.2 * (1.0 - SPEED / 5700.0)
CURRENT = TORQUE / 0.018 + 1.8 + 2e-4 * SPEED  # for no load, friction
ASKED = "each row is an operating point, where a torque measured at the shaft goes with Current (A) too"


def table(torque):
    return {"Speed (RPM)": SPEED, torque: np.round(TORQUE, 4), "Current (A)": np.round(CURRENT, 3)}


@pytest.mark.parametrize("name", ["Torque (Nm)", "M (Nm)", "Measured torque [N m]"])
def test_it_is_asked_whose_torque_it_is(drafted, name):
    draft = drafted(table(name))
    assert f"{name} → motor_torque" in draft.said
    asked = f"{name}: the motor's torque, though {ASKED} (if a dynamometer or a load sensor measured it, say so"
    assert asked in draft.said and "as in 'load torque [N m]'" in draft.said
    assert f"# CHECK: {ASKED}: is it the motor's, or a dynamometer's?" in draft.map


def test_following_that_makes_it_the_load(drafted):
    draft = drafted(table("load torque (Nm)"))
    assert "load torque (Nm) → load_torque" in draft.said and "dynamometer" not in draft.said + draft.map


@pytest.mark.parametrize("name", ["motor torque (Nm)", "estimated torque (Nm)", "calculated torque [N m]"])
def test_what_a_name_says_is_not_asked(drafted, name):
    draft = drafted(table(name))
    assert "motor_torque" in draft.said and "dynamometer" not in draft.said + draft.map


def test_samples_of_a_motion_are_not_asked_about(drafted):
    time = np.arange(600) * 2e-3
    speed = 40.0 * np.sin(6.0 * time)
    torque = 0.1 * np.sign(speed) + 0.05 * np.cos(6.0 * time)
    columns = {"time [s]": time, "speed [rad/s]": speed, "Torque (Nm)": torque, "Current (A)": torque / 0.018}
    draft = drafted(columns)
    assert "Torque (Nm) → motor_torque" in draft.said and "dynamometer" not in draft.said + draft.map


def test_what_is_the_current_to_the_last_digit_is_computed(drafted):
    columns = {"Speed (RPM)": SPEED, "Torque (Nm)": 0.018 * CURRENT, "Current (A)": CURRENT}
    draft = drafted(columns)
    assert "Torque (Nm) → motor_torque" in draft.said and "dynamometer" not in draft.said + draft.map


def test_a_torque_alone_tells_what_is_lacking(drafted):
    """Its noise depends on nothing that was recorded."""
    assert "No motor position or speed was found" in drafted({"TorqueValue": np.sin(7.0 * SPEED)}).said
