"""A machine whose signals are given at its joint has the model of the same machine given at its motor."""

import math

import numpy as np
import pytest

from ema_twin_sim.commands.init import run as init
from ema_twin_sim.model import load_model
from tests.trace_text import write_columns

RATIO = 50.0
GAIN, INTEGRAL_TIME = 0.015, 0.03  # N m s/rad and s, of the drive's speed controller
CONSTANT = 0.1  # N m/A


def sampled(count=4000, period=5e-4, encoder=8192.0 / RATIO):
    """Torque, speed, its setpoint and position of the motor behind a PI speed controller, with the sensors' noise.

    The speed follows its setpoint 5 ms late, and the encoder is on the output: 8192 counts a turn.
    """
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


def write(place, shaft, time, columns):
    """The trace with its ``columns`` named and given at a ``shaft``."""
    geared = {"motor": 1.0, "joint": RATIO}[shaft]
    given = {
        f"{shaft} {name}": values * geared if name.startswith("torque") else values / geared
        for name, values in columns.items()
    }
    return write_columns(place, {"time [s]": time, **given})


def constants(place):
    return {path: held.value for path, held in load_model(place).constants.items()}


def test_a_model_is_the_same_whichever_shaft_its_trace_is_given_at(tmp_path):
    time, columns = sampled()
    for shaft in ("motor", "joint"):
        init(str(tmp_path / shaft), [write(tmp_path / f"{shaft}.csv", shaft, time, columns)], gear_ratio=RATIO)
    drawn = (tmp_path / "joint_map.yaml").read_text()
    assert drawn.count("shaft: output") == len(columns)
    init(
        str(tmp_path / "mapped"),
        [tmp_path / "joint.csv"],
        gear_ratio=RATIO,
        import_map=str(tmp_path / "joint_map.yaml"),
    )
    motor, joint, mapped = (constants(tmp_path / f"{name}.yaml") for name in ("motor", "joint", "mapped"))
    assert motor["drive.speed_gain"] == pytest.approx(GAIN, rel=0.05)
    counts = "sensors.motor_encoder_counts"
    assert joint[counts] == pytest.approx(8192.0 / RATIO)  # a power of two per turn of the joint
    assert motor.pop(counts) == pytest.approx(joint[counts], rel=0.02)
    for other in (joint, mapped):
        assert {path: other[path] for path in motor} == pytest.approx(motor, rel=1e-3)


def test_steady_rows_given_at_the_joint_have_the_motors_noise(tmp_path):
    """Noise that is not divided by the gear ratio hides every effect behind it."""
    speed, random = np.linspace(-2.0, 2.0, 200), np.random.default_rng(3)
    torque = 3.0 * np.sign(speed) + speed + random.normal(0.0, 0.05, len(speed))
    trace = write_columns(tmp_path / "a.csv", {"joint velocity [rad/s]": speed, "joint torque [N m]": torque})
    init(str(tmp_path / "a"), [trace], gear_ratio=RATIO)
    model = load_model(tmp_path / "a.yaml")
    assert model.value("sensors.current_noise") == pytest.approx(0.05 / RATIO, rel=0.15)


def test_gains_of_a_drive_follow_the_motors_share_of_a_joints_torque_constant(tmp_path):
    """A torque constant that must be the joint's is divided by the gear ratio, and so are the gains it scales."""
    time, columns = sampled()
    current = {"motor current [A]": columns.pop("torque [N m]") / CONSTANT}
    columns = {f"motor {name}": values for name, values in columns.items()} | current
    write_columns(tmp_path / "a.csv", {"time [s]": time, **columns})
    found = {}
    for told in (CONSTANT, CONSTANT * RATIO * 4.0):
        init(str(tmp_path / "a"), [tmp_path / "a.csv"], gear_ratio=RATIO, torque_constant=told, force=True)
        model = load_model(tmp_path / "a.yaml")
        found[told] = model.value("drive.speed_gain") / model.value("machine.torque_constant")
    small, large = found.values()
    assert large == pytest.approx(small, rel=1e-3)


def test_the_counts_of_a_joints_encoder_are_told_as_the_outputs(tmp_path, capsys):
    """They were those of a motor encoder, 164 counts per turn of the motor."""
    time, columns = sampled()
    init(str(tmp_path / "joint"), [write(tmp_path / "joint.csv", "joint", time, columns)], gear_ratio=RATIO)
    said = " ".join(capsys.readouterr().out.split())
    assert "output encoder 8192 counts per turn" in said and "motor encoder" not in said
    assert constants(tmp_path / "joint.yaml")["sensors.motor_encoder_counts"] == pytest.approx(8192.0 / RATIO)


def test_the_advice_in_a_map_on_the_other_shaft_is_none_of_its_content(tmp_path, capsys):
    time, columns = sampled(encoder=8192.0)
    named = {name.replace("position", "angle"): values for name, values in columns.items()}
    named |= {"output position [rad]": columns["position [rad]"] / RATIO}
    init(str(tmp_path / "a"), [write_columns(tmp_path / "a.csv", {"time [s]": time, **named})])
    said = " ".join(capsys.readouterr().out.split())
    assert "add `shaft: output`" in (tmp_path / "a_map.yaml").read_text()
    assert "motor encoder 8192 counts per turn" in said
