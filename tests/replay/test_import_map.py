"""Import maps: the shipped one is sound, columns are found by it, and each mistake in one is named."""

import math

import numpy as np
import pytest

from ema_bench_replay.configuration import configuration_names
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.traces.import_map import Column, load_map
from ema_bench_replay.traces.lacked_columns import lacked_columns
from ema_twin_sim.model.matching import matched
from tests.one_line import refused_in_one_line
from tests.trace_text import write_map

MAP = """
version: 1
time: {column: 't \\[s\\]', unit: s}
signals:
  motor_position: {columns: [position], unit: deg, factor: -1}
  output_position: {columns: [r5], counts_per_revolution: 1000, bits: 16}
  motor_torque: {columns: ['force.*', voltage], factor: 35.15}
"""


@pytest.fixture
def own(tmp_path):
    """Write a map and return its path."""

    def write(text):
        path = tmp_path / "own.yaml"
        path.write_text(text)
        return path

    return write


def test_whatever_is_told_at_the_output_is_taken_to_the_motor(tmp_path, stock):
    """The same motion at either shaft: angles and speeds times the ratio, torques over it."""
    ratio = stock.value("machine.gear_ratio")
    factors = {"motor_position": ratio, "speed": ratio, "motor_torque": 1.0 / ratio, "load_torque": 1.0 / ratio}
    import_map = write_map(tmp_path, {name: f"{{columns: [{name}], shaft: output}}" for name in factors})
    trace = tmp_path / "joint.csv"
    trace.write_text(f"t,{','.join(factors)}\n0.000,0.5,0.1,10,20\n0.001,0.6,0.2,11,21\n0.002,0.7,0.3,12,22\n")
    told = load(trace, import_map=import_map)
    at_motor = matched(told, stock)
    for name, factor in factors.items():
        assert np.allclose(at_motor.signals[name], told.signals[name] * factor)
    assert at_motor.motor_angle_origin == pytest.approx(0.5 * ratio)
    assert matched(at_motor, stock) is at_motor  # once only


@pytest.mark.parametrize("name", configuration_names("maps"))
def test_shipped_maps_load(name):
    assert load_map(name).name == name and load_map(name).signals


def test_siemens_units():
    factors = {signal.signal: signal.factor for signal in load_map("siemens").signals}
    assert factors["output_position"] == 2 * math.pi / 4_000_000
    assert factors["motor_position"] == 2 * math.pi / 40_960
    assert factors["speed"] == factors["speed_setpoint"] == 2 * math.pi / 60
    assert factors["current"] == factors["current_setpoint"] == factors["voltage"] == 1.0


@pytest.mark.parametrize(
    ("header", "near"), [("t [s],Position,R5,Voltge", "Voltge"), ("t [s],Position,R5,power", None)]
)
def test_a_misspelt_column_is_told(own, tmp_path, header, near):
    path = tmp_path / "drive.csv"
    path.write_text(f"{header}\n0.000,90,0,1.5\n0.001,91,5,-1.5\n0.002,93,4,2\n")
    recording = load(path, import_map=own(MAP))
    assert not recording.has("motor_torque")
    (warning,) = [warning for warning in recording.warnings if "motor torque" in warning]
    assert "the map 'own' reads the motor torque from 'force.*' or 'voltage', none of which is there" in warning
    assert warning.endswith("correct the map if 'Voltge' is meant" if near else "the recording is read without it")


def test_another_drive_needs_no_code(own, tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text("t [s],Position,R5,voltage\n0.000,90,65530,1.5\n0.001,91,65535,-1.5\n0.002,93,4,2\n")
    recording = load(path, import_map=own(MAP))
    assert recording.stamps.tolist() == [0, 1_000_000, 2_000_000]
    assert np.allclose(recording.signals["motor_position"], np.deg2rad([0, -1, -3]))
    assert recording.motor_angle_origin == pytest.approx(-math.pi / 2)
    assert np.allclose(recording.signals["output_position"], 2 * math.pi / 1000 * np.array([0, 5, 10]))
    assert recording.signals["motor_torque"].tolist() == [1.5 * 35.15, -1.5 * 35.15, 2 * 35.15]
    [warning] = recording.warnings
    assert "R5: counter wrapped (-65536 counts) at 0.002 s; unwrapped" in warning


def test_command_is_measured_from_the_zero_of_the_position(tmp_path):
    path = tmp_path / "drive.csv"
    path.write_text("t,position,command\n0,10,11\n1,10.5,12\n")
    columns = {"output_position": "{columns: [position]}", "output_command": "{columns: [command]}"}
    signals = load(path, import_map=write_map(tmp_path, columns)).signals
    assert signals["output_position"].tolist() == [0.0, 0.5] and signals["output_command"].tolist() == [1.0, 2.0]


@pytest.mark.parametrize(
    ("column", "header", "found"),
    [
        ("r78", ["r780", "r7", "r8"], []),
        ("r78", ["r78[1]", "r78[0]"], [1, 0]),
        ("r78", ["r78[0]", "r78"], [1]),
        ("r4821", ["r482[0]", "r482[1]"], [1]),
        ("r482[1]", ["r4820", "r4821"], [1]),
        ("r63[1]", ["r63[0]", "r63[1]", "r63"], [1]),
        ("r63", ["Drive_axis_1.r0063 [rpm]"], [0]),
        ("r62", ["C2:Drive_axis_1.r62", "C3:Drive_axis_2.r62"], [0, 1]),
        ("speed", ["Speed", "speed 2"], [0]),
        ("speed.*", ["Speed", "speed 2"], [0, 1]),
        ("position [deg]", ["position [deg]"], [0]),
    ],
)
def test_columns_are_found(column, header, found):
    assert Column(column).find(header) == found


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("version: 1", "version: 2", ["version", "2"]),
        ("version: 1\n", "", ["'version' is missing"]),
        ("version: 1", "version: 1\nsignal: 3", ["unknown key 'signal'", "did you mean 'signals'"]),
        ("motor_position", "motor_positon", ["signals", "did you mean 'motor_position'"]),
        ("factor: -1", "facto: -1", ["signals.motor_position", "did you mean 'factor'"]),
        ("factor: -1", "factor: 0", ["signals.motor_position.factor", "is 0"]),
        ("factor: -1", "factor: fast", ["signals.motor_position.factor", "'fast' is no number"]),
        ("unit: deg", "unit: degree", ["signals.motor_position.unit", "did you mean 'deg"]),
        ("unit: deg", "bits: 32", ["signals.motor_position.bits", "counts_per_revolution"]),
        ("bits: 16", "bits: 17", ["signals.output_position.bits", "17"]),
        ("bits: 16", "unit: deg", ["signals.output_position.unit", "counts_per_revolution"]),
        ("1000", "-1000", ["counts_per_revolution", "out of range"]),
        ("[position]", "position", ["signals.motor_position.columns", "no list"]),
        ("'force.*'", "'force('", ["signals.motor_torque.columns[0]", "regular expression"]),
        ("voltage]", "{column: v, follow: w}]", ["signals.motor_torque.columns[1]", "did you mean 'follows'"]),
        ("unit: s}", "unit: h}", ["time.unit", "'h'"]),
        ("signals:", "delimiter: '|'\nsignals:", ["delimiter", "'|'"]),
        ("version: 1", "version: [1", ["line", "YAML"]),
    ],
)
def test_mistakes_are_named(own, old, new, words):
    path = own(MAP.replace(old, new, 1))
    with refused_in_one_line(path, *words):
        load_map(path)


def test_a_map_of_nothing(own):
    with pytest.raises(InputError, match="no mapping"):
        load_map(own(""))
    with pytest.raises(InputError, match="names no signal"):
        load_map(own("version: 1\ntime: {column: t, unit: s}\nsignals: {}\n"))


def test_unknown_map():
    with pytest.raises(InputError, match="did you mean 'siemens'"):
        load_map("simens")


@pytest.mark.parametrize(
    ("header", "told"),
    [
        ("position [rad]", "rad"),
        ("position (rad)", "rad"),
        ("position_rad", "rad"),
        ("position [deg]", None),
        ("position [°]", None),
        ("position_m", None),  # the motor's
        ("position", None),
    ],
)
def test_a_header_that_tells_another_unit_than_the_map_is_warned_of(tmp_path, header, told):
    path = tmp_path / "drive.csv"
    path.write_text(f"t,{header},torque\n0.000,90,0\n0.001,91,5\n0.002,93,4\n")
    signals = {"motor_position": "{columns: ['position.*'], unit: deg}", "motor_torque": "{columns: [torque]}"}
    warnings = load(path, import_map=write_map(tmp_path, signals)).warnings
    assert len(warnings) == (told is not None)
    for warning in warnings:
        assert warning.startswith(f"drive.csv: the column {header!r} is in rad by its name, but the map 'own' reads it")
        assert "in deg; write `unit: rad` into the map" in warning
    signals["motor_position"] = "{columns: ['position.*'], factor: 57.3}"  # its own conversion is a map's own business
    assert load(path, import_map=write_map(tmp_path, signals)).warnings == ()


@pytest.mark.parametrize(
    ("header", "told"),
    [
        ("t,q,torq", "run.csv has no column 'tau' (motor torque), which the map 'own' reads"),
        ("t,q,tau", ""),
        ("t,tau", ""),
    ],
)
def test_a_column_that_a_file_lacks_is_named_for_what_needs_it(tmp_path, header, told):
    signals = {"motor_torque": "{columns: [tau], unit: N m}", "motor_position": "{columns: [q], unit: rad}"}
    own = write_map(tmp_path, signals, "time: {column: '^t$', unit: s}")
    cells = header.count(",") + 1
    rows = [",".join([f"{row}.5"] * cells) for row in range(5)]
    (tmp_path / "run.csv").write_text("\n".join([header, *rows, ""]))
    recording = load(tmp_path / "run.csv", import_map=own)
    said = lacked_columns(recording, ("current", "motor_torque"))
    assert said.startswith(told) and bool(said) == bool(told)
    assert ("'q'" in lacked_columns(recording, ("motor_position",))) == ("q" not in header)
