"""`init` with a command of the torque or current: it serves if neither was measured."""

import numpy as np
import pytest

from ema_bench_replay.load import load
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.new_machine.columns import guess_columns
from tests.trace_text import write_columns

TIME = np.arange(1500) * 2e-3
ANGLE = 1.2 * np.sin(3.0 * TIME)
SPEED = 3.6 * np.cos(3.0 * TIME)
DRIVE = -0.9 * ANGLE + 0.2 * SPEED + 0.3 * np.sign(SPEED)


def written(place, **columns):
    return write_columns(place, {"time [s]": TIME, "angle [rad]": ANGLE, "speed [rad/s]": SPEED, **columns})


TORQUES = ["tau_cmd [Nm]", "tau_des", "tau_ref", "des_torque", "torque_command", "torque setpoint [Nm]", "Moment soll"]
CURRENTS = ["iq_ref", "i_cmd", "current setpoint [A]", "Iq*"]


@pytest.mark.parametrize(
    ("name", "signal"), [*((name, "motor_torque") for name in TORQUES), *((name, "current") for name in CURRENTS)]
)
def test_a_command_alone_is_used_said_and_marked(tmp_path, capsys, name, signal):
    trace = written(tmp_path / "run.csv", **{name: DRIVE})
    init(str(tmp_path / "m"), [trace])
    told = " ".join(capsys.readouterr().out.split())
    assert f"{name} → {signal}" in told and ", a command" in told
    assert f"Assumed: {name}: a command, which the drive is assumed to follow" in told
    assert "No current or torque was found" not in told and "sign of" in told
    drawn = (tmp_path / "m_map.yaml").read_text()
    line = next(line for line in drawn.splitlines() if line.startswith(f"  {signal}:"))
    assert "# CHECK: " in line and "a command: the drive is assumed to follow it" in line
    assert load(trace, import_map=tmp_path / "m_map.yaml").signals[signal] == pytest.approx(DRIVE, abs=1e-6)


@pytest.mark.parametrize(
    ("measured", "signal"),
    [("current [A]", "current"), ("torque [Nm]", "motor_torque"), ("iq_meas", "current"), ("tau_act", "motor_torque")],
)
@pytest.mark.parametrize("command", ["tau_cmd [Nm]", "iq_ref"])
def test_what_was_measured_goes_before_a_command(measured, signal, command):
    numbers = {"time [s]": TIME, "angle [rad]": ANGLE, command: DRIVE, measured: DRIVE + 0.1}
    found = {guess.signal: guess for guess in guess_columns(list(numbers), numbers=numbers).signals}
    assert found[signal].column == measured
    assert not any(guess.command for guess in found.values())


def test_a_torque_command_goes_before_one_of_the_current_which_stays_a_setpoint():
    numbers = {"time [s]": TIME, "angle [rad]": ANGLE, "iq_ref": DRIVE, "tau_cmd [Nm]": DRIVE}
    found = {guess.signal: guess.column for guess in guess_columns(list(numbers), numbers=numbers).signals}
    assert found["motor_torque"] == "tau_cmd [Nm]" and found["current_setpoint"] == "iq_ref"


def test_a_command_that_never_changes_is_not_used():
    numbers = {"time [s]": TIME, "angle [rad]": ANGLE, "tau_cmd [Nm]": 0.0 * TIME, "bus current [A]": np.abs(DRIVE)}
    found = {guess.signal: guess.column for guess in guess_columns(list(numbers), numbers=numbers).signals}
    assert found["current"] == "bus current [A]" and "motor_torque" not in found


def test_joints_that_are_commanded_are_told_apart():
    numbers = {"time [s]": TIME}
    for joint, size in ((1, 1.0), (2, 3.0)):
        numbers |= {f"q{joint} [rad]": size * np.sin(joint * TIME), f"tau_cmd{joint} [Nm]": np.cos(joint * TIME)}
    guesses = guess_columns(list(numbers), numbers=numbers)
    assert guesses.joint.name == "2"
    assert {guess.signal: guess.column for guess in guesses.signals} == {
        "motor_position": "q2 [rad]",
        "motor_torque": "tau_cmd2 [Nm]",
    }
