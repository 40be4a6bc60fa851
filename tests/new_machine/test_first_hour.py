"""The first hour with one's own machine: what is wrong in what one has is said at once, with what to do."""

import re
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.commands import add, init, shown_live
from ema_twin_sim.commands.main import application
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.nodes.live_session import WAIT, LiveResult, Session
from tests.servo_csv import TORQUE_CONSTANT, write_servo
from tests.trace_text import write_columns


@pytest.fixture(scope="module")
def servo(tmp_path_factory):
    return write_servo(tmp_path_factory.mktemp("servo"))


@pytest.fixture
def told(drafted):
    """What `init` says and warns of these files."""
    return lambda files, **options: drafted(*files, torque_constant=TORQUE_CONSTANT, **options).told


def test_a_gear_ratio_that_the_encoders_contradict_is_asked_about_and_refused(servo, tmp_path, told, drawn):
    assert "both positions give" not in told(servo, gear_ratio=80.0)
    said = told(servo, gear_ratio=50.0)
    assert "the gear ratio was given as 50, but both positions give 80; leave --gear-ratio out" in said
    recordings = [load(file, import_map=tmp_path / "m_map.yaml") for file in servo]
    with pytest.raises(InputError, match=r"0\.625 times .* machine\.gear_ratio \(with 80 they fit\)"):
        discover(recordings, drawn())


def renamed(file, folder, names):
    """The file with other names of some columns in its header."""
    header, _, rows = file.read_text().partition("\n")
    for name, other in names.items():
        assert name in header
        header = header.replace(name, other)
    written = folder / file.name
    written.write_text(f"{header}\n{rows}")
    return written


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "said"),
    [
        (
            {"current [A]": "current [rad/s]", "motor speed [rad/s]": "motor speed [A]"},
            "current [rad/s]: its name says current, its unit rad/s",
        ),
        (
            {"motor position [rad]": "motor position [rad/s]", "motor speed [rad/s]": "motor speed [rad]"},
            "motor speed [rad]: its name says speed, its unit rad",
        ),
    ],
    ids=["current and speed", "position and speed"],
)
def test_a_unit_that_contradicts_its_columns_name_is_told_at_once(servo, tmp_path, told, names, said):
    assert "its name says" not in told(servo)
    swapped = told([renamed(file, tmp_path, names) for file in servo])
    assert swapped.count("its name says") == 2 and said in swapped


def test_a_trace_whose_end_is_cut_is_drafted_from_and_told_of(servo, tmp_path, told):
    cut = tmp_path / servo[0].name
    cut.write_bytes(servo[0].read_bytes().rstrip()[:-4])
    line = len(servo[0].read_text().splitlines())
    said = f"warning: {cut.name}: line {line}: the last row is cut, so only the rows before it can be used"
    assert "is cut" not in told(servo)
    assert told([cut]).count(said) == told([cut], import_map=str(tmp_path / "m_map.yaml")).count(said) == 1


@pytest.mark.parametrize(("name", "other"), [("current", "Strom"), ("time", "Zeit")])
def test_traces_whose_columns_have_other_names_are_refused_with_a_way_out(servo, tmp_path, told, name, other):
    """A map of the first one's columns would read nothing of them, and say nothing."""
    with pytest.raises(InputError, match=rf"'{other} \[.*give both the same names, or"):
        told([servo[0], renamed(servo[1], tmp_path, {name: other})])


def test_columns_that_only_some_traces_have_are_told(tmp_path, told, servo):
    fewer = write_servo(tmp_path, signals=("motor_position", "output_position", "speed"))
    assert "run_1.csv: lacks the column 'current [A]', 'speed setpoint [rad/s]'" in told([servo[0], fewer[1]])
    assert f"list {servo[1]} first to use it" in told([fewer[0], servo[1]])


@pytest.mark.parametrize(
    ("header", "lacked"), [(["break-away torque [Nm]"], "time column"), (["time [s]", "temperature [degC]"], "column")]
)
def test_a_trace_of_another_kind_is_refused_in_words_of_both(header, lacked, tmp_path, told, servo):
    other = write_columns(tmp_path / "other.csv", {name: np.arange(50.0) + k for k, name in enumerate(header)})
    with pytest.raises(InputError, match=f"other.csv: lacks the {lacked} .*of .*so one map cannot read both; run init"):
        told([servo[0], other])


def test_a_trace_without_a_position_leads_to_no_command_that_refuses_it(drafted):
    time = np.arange(400) * 1e-3
    columns = {"time [s]": time, "current [A]": np.sin(9.0 * time), "speed setpoint [rad/s]": np.cos(9.0 * time)}
    said = drafted(columns).said
    assert "No motor position or speed was found: add its column to" in said
    assert "no line to check, but a signal" in said
    assert "ema-twin info" in said and "ema-twin discover" not in said


def test_what_encoders_alone_can_show_is_told_before_the_commands(tmp_path, capsys):
    time = np.arange(4000) * 1e-3
    swing = np.sin(3.0 * time)
    columns = {"time [s]": time, "motor position [rad]": 50.0 * swing, "output position [rad]": swing}
    init.run(str(tmp_path / "m"), [write_columns(tmp_path / "run.csv", columns)])
    lines = capsys.readouterr().out.splitlines()
    commands = lines[lines.index("Then:") + 1 :]
    assert len(commands) == 4 and all(line.startswith("  ema-twin ") for line in commands)
    assert any(line.startswith("No current or torque was found: only backlash") for line in lines)


@pytest.mark.parametrize(
    ("seed", "told"),
    [("x", "x is no whole number; give 0 to 1000000000"), ("-3", "-3 is out of range; give 0 to 1000000000")],
)
def test_a_seed_that_is_none_is_refused_in_our_words(seed, told):
    with pytest.raises(Exception) as refused:
        application()(["simulate", "-m", "polito_bench", "-o", "run.mcap", f"--seed={seed}"], standalone_mode=False)
    assert told in refused.value.format_message()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--gear-ratio", "0"), "--gear-ratio.*0 is out of range; give 0.001 to 100000 turns of the motor per turn of"),
        (("--gear-ratio", "five"), "--gear-ratio.*five is no number; give 0.001 to 100000 turns"),
        (("--torque-constant", "-1"), r"--torque-constant.*-1 is out of range; give 1e-06 to 1e\+09 N m/A"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_a_number_that_is_none_is_refused_with_its_bounds_and_unit(options, told):
    with pytest.raises(Exception) as refused:
        application()(["init", "trace.csv", "-o", "servo", *options], standalone_mode=False)
    assert re.search(told, refused.value.format_message())


ONE_INERTIA = """
version: 1
machine:
  name: one
  inertia: {value: 1e-4, unit: kg m^2, tolerance: open, source: guess}
  gear_ratio: {value: 80, unit: "1"}
transmission: {kind: rigid}
sensors: {}
effects: {}
"""


def test_play_is_added_to_no_model_that_has_nothing_behind_it(tmp_path):
    (tmp_path / "one.yaml").write_text(ONE_INERTIA)
    new = tmp_path / "new.yaml"
    with pytest.raises(
        InputError, match=r"machine\.output_inertia is 0.*write what of the inertia is behind the gearbox"
    ):
        add.run("backlash", str(tmp_path / "one.yaml"), new)
    assert not new.exists()
    add.run("gravity_load", str(tmp_path / "one.yaml"), new)
    assert new.exists()


@pytest.mark.parametrize(
    ("compared", "missing", "complete", "loop", "told"),
    [
        (9000, 0, True, False, "all 9000 samples compared"),
        (9000, 0, True, True, "all 9000 samples compared in the last pass"),
        (1200, 0, False, True, "1200 of 9000 samples compared, ended during this pass of the loop, none missing"),
        (1200, 0, False, False, "1200 of 9000 samples compared, stopped early, none missing"),
        (8990, 10, False, False, "8990 of 9000 samples compared, 10 missing"),
    ],
)
def test_a_live_run_that_was_ended_is_not_told_as_one_that_lost_samples(compared, missing, complete, loop, told):
    counts = {"sent": compared, "compared": compared, "missing": missing, "expected": 9000}
    ended = LiveResult("run", "servo", "setpoint", compared, 9.0, {}, complete, interrupted=False, counts=counts)
    assert shown_live.how_much(ended, loop=loop) == told


def test_a_live_run_that_no_bench_was_there_for_is_told_so_with_what_to_start(capsys):
    """It was told as 0 of 0 samples compared, stopped early, none missing."""
    counts = {"sent": 0, "compared": 0, "missing": 0, "expected": 0}
    ended = LiveResult("bench", "servo", "setpoint", 0, 0.0, {}, complete=False, interrupted=False, counts=counts)
    shown_live.show(ended)
    told = " ".join(capsys.readouterr().out.split())
    assert "live: nothing was compared, input setpoint No bench publishes /bench/state. Start the bench, or" in told
    assert "--ros-args -p recording:=RUN" in told and "ema-twin live RUN" in told


def test_who_waits_for_a_bench_is_told_once_that_there_is_none():
    pairing = SimpleNamespace(bench=SimpleNamespace(received=0))
    told = []
    monitor = SimpleNamespace(mixed="", pairing=pairing)
    session = Session(None, monitor, None, [], None, told.append, threading.Event())
    session.tick()
    assert told == []
    session.started -= 2.0 * WAIT
    session.tick()
    session.tick()
    assert len(told) == 1 and told[0].startswith("No bench publishes /bench/state.")


def test_a_speed_in_whole_numbers_is_asked_about(drafted):
    """A drive's "Servo motor speed" in turns per minute, without a unit, was read in rad/s without a word."""
    time = np.arange(2000) * 1e-3
    speed = 900.0 * np.sin(3.0 * time)
    columns = {"time [s]": time, "Servo motor speed": np.round(speed), "torque [N m]": 0.1 * np.sign(speed)}
    said = drafted(columns).told
    assert "speed goes in steps of 1 rad/s, as of whole numbers, and no unit is given; is its column in rpm" in said
    del columns["Servo motor speed"]
    for name, values in (("Servo motor speed", np.round(speed, 1)), ("Servo motor speed [rad/s]", np.round(speed))):
        assert "whole numbers" not in drafted({**columns, name: values}).told
