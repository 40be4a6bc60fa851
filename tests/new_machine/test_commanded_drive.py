"""`init` with a command of the torque or current: it serves if neither was measured."""

import numpy as np
import pytest

from tests.taken_columns import guessed, taken

TIME = np.arange(1500) * 2e-3
ANGLE = 1.2 * np.sin(3.0 * TIME)
SPEED = 3.6 * np.cos(3.0 * TIME)
DRIVE = -0.9 * ANGLE + 0.2 * SPEED + 0.3 * np.sign(SPEED)


TORQUES = ["tau_cmd [Nm]", "tau_des", "tau_ref", "des_torque", "torque_command", "torque setpoint [Nm]", "Moment soll"]
CURRENTS = ["iq_ref", "i_cmd", "current setpoint [A]", "Iq*"]


@pytest.mark.parametrize(
    ("name", "signal"), [*((name, "motor_torque") for name in TORQUES), *((name, "current") for name in CURRENTS)]
)
def test_a_command_alone_is_used_said_and_marked(drafted, read, name, signal):
    draft = drafted({"time [s]": TIME, "angle [rad]": ANGLE, "speed [rad/s]": SPEED, name: DRIVE})
    assert f"{name} → {signal}" in draft.said and ", a command" in draft.said
    assert f"Assumed: {name}: a command, which the drive is assumed to follow" in draft.said
    assert "No current or torque was found" not in draft.said and "sign of" in draft.said
    assert "# CHECK: " in draft.line(signal) and "a command: the drive is assumed to follow it" in draft.line(signal)
    assert read().signals[signal] == pytest.approx(DRIVE, abs=1e-6)


@pytest.mark.parametrize(
    ("measured", "signal"),
    [("current [A]", "current"), ("torque [Nm]", "motor_torque"), ("iq_meas", "current"), ("tau_act", "motor_torque")],
)
@pytest.mark.parametrize("command", ["tau_cmd [Nm]", "iq_ref"])
def test_what_was_measured_goes_before_a_command(measured, signal, command):
    numbers = {"time [s]": TIME, "angle [rad]": ANGLE, command: DRIVE, measured: DRIVE + 0.1}
    found = {guess.signal: guess for guess in guessed(numbers).signals}
    assert found[signal].column == measured
    assert not any(guess.command for guess in found.values())


def test_a_torque_command_goes_before_one_of_the_current_which_stays_a_setpoint():
    numbers = {"time [s]": TIME, "angle [rad]": ANGLE, "iq_ref": DRIVE, "tau_cmd [Nm]": DRIVE}
    found = taken(numbers)
    assert found["motor_torque"] == "tau_cmd [Nm]" and found["current_setpoint"] == "iq_ref"


def test_a_command_that_never_changes_is_not_used():
    numbers = {"time [s]": TIME, "angle [rad]": ANGLE, "tau_cmd [Nm]": 0.0 * TIME, "bus current [A]": np.abs(DRIVE)}
    found = taken(numbers)
    assert found["current"] == "bus current [A]" and "motor_torque" not in found


def test_joints_that_are_commanded_are_told_apart():
    numbers = {"time [s]": TIME}
    for joint, size in ((1, 1.0), (2, 3.0)):
        numbers |= {f"q{joint} [rad]": size * np.sin(joint * TIME), f"tau_cmd{joint} [Nm]": np.cos(joint * TIME)}
    assert guessed(numbers).joint.name == "2"
    assert taken(numbers) == {"motor_position": "q2 [rad]", "motor_torque": "tau_cmd2 [Nm]"}
