"""A joint's torque sensor that shows many times the motor's torque: `init` asks for the gear ratio."""

import numpy as np
import pytest

from ema_bench_replay.recording import AT, Recording
from ema_twin_sim.measured.load_sensor import load_over_motor_torque
from ema_twin_sim.new_machine.load_beside_motor import shown_gear

TIME = np.arange(6000) * 2e-3
ANGLE = 0.8 * np.sin(1.1 * TIME) + 0.3 * np.sin(2.9 * TIME)
SPEED = np.gradient(ANGLE, TIME)
LOAD = 25.0 * np.sin(ANGLE + 0.4) + 0.8 * np.gradient(SPEED, TIME)


def torques(gear):
    """Motor's and sensor's torque of a joint behind that gear."""
    noise = np.random.default_rng(5).standard_normal((2, len(TIME)))
    motor = LOAD / gear + (2.0 * np.sign(SPEED) + 1.5 * SPEED) / gear + 1e-4 * np.gradient(SPEED, TIME)
    return motor + 0.3 / gear * noise[0], LOAD + 0.05 * noise[1]


def arm(gear):
    motor, sensor = torques(gear)
    columns = {"time [s]": TIME, "joint angle [rad]": ANGLE, "joint velocity [rad/s]": SPEED}
    return columns | {"motor torque [Nm]": motor, "joint torque sensor [Nm]": sensor}


@pytest.mark.parametrize("gear", [8.0, 50.0, 140.0])
def test_the_ratio_is_proposed(drafted, gear):
    draft = drafted(arm(gear))
    about = float(draft.told.partition("from the data sheet (about ")[2].partition(")")[0])
    assert about == pytest.approx(gear, rel=0.1)
    assert f"run0: the load's torque changes about {about:g} times as much as the motor's" in draft.told
    line = draft.line("gear_ratio")
    assert "value: 1," in line and f"# CHECK: the load's torque changes about {about:g} times" in line


def test_a_ratio_that_is_given_is_not_asked_for(drafted):
    draft = drafted(arm(50.0), gear_ratio=50.0)
    assert "value: 50," in draft.line("gear_ratio")
    assert "times as much as the motor's" not in draft.told + draft.model


def test_without_a_gear_nothing_is_asked(drafted):
    draft = drafted(arm(1.0))
    assert "times as much as the motor's" not in draft.told + draft.model


def recording(motor, sensor, at="output"):
    signals = {"motor_torque": motor, "load_torque": sensor, "motor_position": ANGLE, "speed": SPEED}
    return Recording("arm", np.arange(len(TIME)) * 2_000_000, signals, metadata={f"load_torque{AT}": at})


def test_a_sensor_that_does_not_go_with_the_motor_shows_no_gear():
    motor, _ = torques(50.0)
    drift = 30.0 * np.sin(0.31 * TIME**1.2)
    assert load_over_motor_torque([recording(motor, drift)]) is None
    assert shown_gear([recording(motor, drift)]) is None


def test_a_sensor_at_the_motor_shows_none_either():
    motor, sensor = torques(50.0)
    assert shown_gear([recording(motor, sensor)]).ratio == pytest.approx(50.0, rel=0.1)
    assert shown_gear([recording(motor, sensor, at="motor")]) is None
