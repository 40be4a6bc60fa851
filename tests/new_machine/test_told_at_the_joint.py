"""A machine whose signals are given at its joint has the model of the same machine given at its motor."""

import math

import numpy as np
import pytest

RATIO = 50.0
GAIN, INTEGRAL_TIME = 0.015, 0.03  # N m s/rad and s, of the drive's speed controller
CONSTANT = 0.1  # N m/A


def sampled(encoder=8192.0 / RATIO):
    """Torque, speed, its setpoint and position of the motor behind a PI speed controller, with the sensors' noise.

    The speed follows its setpoint 5 ms late, and the encoder is on the output: 8192 counts a turn.
    """
    count, period = 4000, 5e-4
    time, random = np.arange(count) * period, np.random.default_rng(11)

    def swung(late):
        return 60.0 * np.sin(6.0 * (time - late)) + 30.0 * np.sin(40.0 * (time - late))

    setpoint, speed = swung(0.0), swung(5e-3) + random.normal(0.0, 0.02, count)
    error = setpoint - speed
    torque = GAIN * (error + np.cumsum(error) * period / INTEGRAL_TIME) + random.normal(0.0, 1e-4, count)
    step = 2.0 * math.pi / encoder
    return time, {
        "torque [N m]": torque,
        "speed [rad/s]": speed,
        "speed setpoint [rad/s]": setpoint,
        "position [rad]": np.floor(np.cumsum(swung(5e-3)) * period / step) * step,
    }


def at(shaft, time, columns):
    """The ``columns`` named and given at a ``shaft``."""
    geared = {"motor": 1.0, "joint": RATIO}[shaft]
    given = {
        f"{shaft} {name}": values * geared if name.startswith("torque") else values / geared
        for name, values in columns.items()
    }
    return {"time [s]": time, **given}


@pytest.fixture
def constants(drawn):
    return lambda: {path: held.value for path, held in drawn().constants.items()}


def test_a_model_is_the_same_whichever_shaft_its_trace_is_given_at(drafted, constants, tmp_path):
    time, columns = sampled()
    drafted(at("motor", time, columns), gear_ratio=RATIO)
    motor = constants()
    drawing = drafted(at("joint", time, columns), gear_ratio=RATIO).map
    assert drawing.count("shaft: output") == len(columns)
    joint = constants()
    drafted(at("joint", time, columns), gear_ratio=RATIO, import_map=str(tmp_path / "m_map.yaml"))
    assert motor["drive.speed_gain"] == pytest.approx(GAIN, rel=0.05)
    counts = "sensors.motor_encoder_counts"
    assert joint[counts] == pytest.approx(8192.0 / RATIO)  # a power of two per turn of the joint
    assert motor.pop(counts) == pytest.approx(joint[counts], rel=0.02)
    for other in (joint, constants()):
        assert {path: other[path] for path in motor} == pytest.approx(motor, rel=1e-3)


def test_steady_rows_given_at_the_joint_have_the_motors_noise(drafted, drawn):
    """Noise that is not divided by the gear ratio hides every effect behind it."""
    speed, random = np.linspace(-2.0, 2.0, 200), np.random.default_rng(3)
    torque = 3.0 * np.sign(speed) + speed + random.normal(0.0, 0.05, len(speed))
    drafted({"joint velocity [rad/s]": speed, "joint torque [N m]": torque}, gear_ratio=RATIO)
    assert drawn().value("sensors.current_noise") == pytest.approx(0.05 / RATIO, rel=0.15)


def test_gains_of_a_drive_follow_the_motors_share_of_a_joints_torque_constant(drafted, drawn):
    """A torque constant that must be the joint's is divided by the gear ratio, and so are the gains it scales."""
    time, columns = sampled()
    current = {"motor current [A]": columns.pop("torque [N m]") / CONSTANT}
    columns = {f"motor {name}": values for name, values in columns.items()} | current
    found = []
    for told in (CONSTANT, CONSTANT * RATIO * 4.0):
        drafted({"time [s]": time, **columns}, gear_ratio=RATIO, torque_constant=told)
        found.append(drawn().value("drive.speed_gain") / drawn().value("machine.torque_constant"))
    assert found[1] == pytest.approx(found[0], rel=1e-3)


def test_the_counts_of_a_joints_encoder_are_told_as_the_outputs(drafted, constants):
    """They were those of a motor encoder, 164 counts per turn of the motor."""
    said = drafted(at("joint", *sampled()), gear_ratio=RATIO).said
    assert "output encoder 8192 counts per turn" in said and "motor encoder" not in said
    assert constants()["sensors.motor_encoder_counts"] == pytest.approx(8192.0 / RATIO)


def test_the_advice_in_a_map_on_the_other_shaft_is_none_of_its_content(drafted):
    time, columns = sampled(encoder=8192.0)
    named = {name.replace("position", "angle"): values for name, values in columns.items()}
    named |= {"output position [rad]": columns["position [rad]"] / RATIO}
    draft = drafted({"time [s]": time, **named})
    assert "add `shaft: output`" in draft.map and "motor encoder 8192 counts per turn" in draft.said
