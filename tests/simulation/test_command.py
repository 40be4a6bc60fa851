"""Commands of the virtual bench."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench


def test_shapes():
    time = np.array([0.0, 0.25, 0.5, 1.0, 1.5, 2.0])
    assert np.allclose(parse_command("ramp:0.05")(time), 0.05 * time)
    assert np.allclose(parse_command("sine:0.02:1")(time), 0.02 * np.sin(2 * np.pi * time))
    assert np.allclose(parse_command("triangle:0.04:1")(time), [0, 0.01, 0.02, 0.04, 0.02, 0])
    assert np.allclose(parse_command("step:0.02:1")(time), [0.02, 0.02, 0.02, 0, 0, 0.02])


def test_start_and_phase():
    assert parse_command("ramp:0.05", start=1.0)(np.zeros(1)) == 1.0
    shifted = parse_command("sine:0.02:1", phase=np.pi / 2)
    assert shifted(np.zeros(1)) == 0.0
    assert shifted(np.array([0.5])) == pytest.approx(-0.04)
    assert parse_command("triangle:0.04:1", phase=np.pi)(np.array([0.0, 0.5])) == pytest.approx([0.0, -0.02])


def test_a_speed_command():
    assert parse_command("speed-step:0.1:1").speed
    assert not parse_command("step:0.1:1").speed


def test_a_file_of_points(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text("time,value\n0,0\n1,0.1\n# rest\n2,0.1\n")
    assert np.allclose(parse_command(str(path))(np.array([0.5, 1.5, 9.0])), [0.05, 0.1, 0.1])


@pytest.mark.parametrize(
    "text",
    [
        "wobble:1",
        "ramp",
        "ramp:x",
        "ramp:1:2",
        "sine:0.02",
        "sine:0.02:0",
        "sine:0.02:-1",
        "ramp:nan",
        "ramp:1e300",
        "sine:1e308:1e308",
        "sine:1:inf",
        "nofile.csv",
    ],
)
def test_what_is_no_command_is_refused_with_the_forms(text):
    with pytest.raises(InputError, match=r"ramp:SPEED|give sine:SIZE:HZ|text file") as refused:
        parse_command(text)
    assert text in str(refused.value)


@pytest.mark.parametrize("text", ["sine:0.05:500", "triangle:0.05:0.0009"])
def test_a_command_faster_than_the_samples_show_is_refused(text):
    """A sine at half the sampling rate was recorded as a standstill, without a word."""
    model = load_model("polito_bench").with_value("sensors.sample_period", 1e-3)
    with pytest.raises(InputError, match="1000 samples a second show no more than 500; give a slower one"):
        virtual_bench(model, parse_command(text), 1.0)
    assert parse_command("step:0.1:0.5").frequency == 1.0 and parse_command("ramp:0.1").frequency == 0.0


def test_a_command_that_grows_too_large_is_refused(tmp_path):
    assert parse_command("ramp:1e5")(np.array([0.0, 9.0])).max() == 9e5
    with pytest.raises(InputError, match=r"'ramp:1e5': grows beyond 1e\+06 rad or m;"):
        parse_command("ramp:1e5")(np.array([0.0, 11.0]))
    path = tmp_path / "points.csv"
    path.write_text("0,0\n1,1e300\n")
    with pytest.raises(InputError, match=r"points\.csv': grows"):
        parse_command(str(path))(np.array([0.5]))


def test_a_byte_order_mark_hides_no_point(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text("0,0\n1,0.1\n2,0.1\n", encoding="utf-8-sig")
    assert parse_command(str(path))(np.array([0.5])) == pytest.approx(0.05)


@pytest.mark.parametrize("seconds", [float("nan"), float("inf"), -1.0])
def test_durations_that_are_none(seconds):
    with pytest.raises(InputError, match="--seconds"):
        virtual_bench(load_model("polito_bench"), parse_command("ramp:0.05"), seconds)


@pytest.mark.parametrize("lines", ["0,0\n", "0,0\n1,x\n", "0,0\n0,1\n", "1,0\n0,1\n", "0,0\n1,nan\n", "0,0\n1,2,3\n"])
def test_bad_points_are_refused_with_their_line(tmp_path, lines):
    path = tmp_path / "points.csv"
    path.write_text(lines)
    with pytest.raises(InputError, match=r"points\.csv"):
        parse_command(str(path))


def test_numbers_of_a_linear_machine_are_in_metres():
    recording = virtual_bench(load_model("emps"), parse_command("ramp:0.05"), 1.0, seed=None)
    assert recording.motion == "linear"
    assert recording.signals["output_command"][-1] == pytest.approx(0.05)
    with pytest.raises(InputError, match=r"takes 1 number; give ramp:SPEED, the first number in rad/s \(m/s if "):
        parse_command("ramp:1:2")
