"""What never changes shows no motion, or no drive: `init` says so, leaves it out, and learns nothing else of it."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.commands.init import run as init
from tests.trace_text import write_columns

TIME = np.arange(600) * 2e-3
SPEED = 40.0 * np.sin(6.0 * TIME)
ANGLE = 40.0 / 6.0 * (1.0 - np.cos(6.0 * TIME))
CURRENT = 0.3 * np.sign(SPEED) + 0.24 * np.cos(6.0 * TIME) + 1e-3 * np.random.default_rng(1).standard_normal(600)
ZERO = np.zeros(600)
SAID = "not used, since it never changes"


def drafted(tmp_path, capsys, *runs, **options):
    traces = [write_columns(tmp_path / f"run{k}.csv", {"time [s]": TIME, **run}) for k, run in enumerate(runs)]
    init(str(tmp_path / "m"), traces, **options)
    return " ".join(capsys.readouterr().out.split()), (tmp_path / "m_map.yaml").read_text()


@pytest.mark.parametrize("still", ["speed [rpm]", "output position [rad]"])
def test_what_is_left_works(tmp_path, capsys, still):
    said, text = drafted(tmp_path, capsys, {"angle [rad]": ANGLE, still: ZERO, "current [A]": CURRENT})
    assert f"{still}: {SAID}" in said and "angle [rad] → motor_position" in said and "ema-twin discover" in said
    assert "speed:" not in text and "output_position:" not in text and f"# not used: {still}" in text


def test_a_position_that_stands_beside_a_speed(tmp_path, capsys):
    said, _ = drafted(tmp_path, capsys, {"angle [rad]": ZERO + 1.5, "speed [rad/s]": SPEED, "current [A]": CURRENT})
    assert "angle [rad]: not used: it stands still, while by the speed the motor moves" in said
    assert "speed [rad/s] → speed" in said


def test_another_column_that_changes_is_taken(tmp_path, capsys):
    rpm = SPEED * 30.0 / np.pi
    run = {"electrical speed (RPM)": ZERO, "optical speed (RPM)": rpm, "current [A]": CURRENT}
    said, text = drafted(tmp_path, capsys, run)
    assert "optical speed (RPM) → speed" in said and "electrical speed" not in text.partition("# not used")[0]


@pytest.mark.parametrize("drive", ["effort [N m]", "current [A]"])
def test_a_drive_that_is_zero_all_along_is_none(tmp_path, capsys, drive):
    """As the efforts of joint states are that nobody fills in."""
    run = {"angle [rad]": ANGLE, "speed [rad/s]": SPEED, drive: ZERO}
    said, text = drafted(tmp_path, capsys, run)
    assert f"{drive}: {SAID}" in said and "No current or torque was found" in said
    assert "current:" not in text and "motor_torque: {columns: ['effort" not in text
    said, _ = drafted(tmp_path, capsys, run, {**run, drive: CURRENT}, force=True)
    assert SAID not in said and f"{drive} → " in said


def test_a_length_that_never_changes_makes_no_machine_linear(tmp_path, capsys):
    """The arm of a brake; by its words it is no position either."""
    run = {"Moment arm (cm)": ZERO + 15.25, "lever (mm)": ZERO + 3.0, "speed [rad/s]": SPEED, "current [A]": CURRENT}
    said, text = drafted(tmp_path, capsys, run)
    assert "speed [rad/s] → speed" in said and "motion: linear" not in text
    moved = {"Moment arm (cm)": 15.0 + ANGLE, "speed [rad/s]": SPEED, "current [A]": CURRENT}
    assert "speed [rad/s] → speed" in drafted(tmp_path, capsys, moved, force=True)[0]


def test_without_any_motion_that_is_said(tmp_path, capsys):
    said, _ = drafted(tmp_path, capsys, {"angle [rad]": ZERO, "speed [rad/s]": ZERO, "current [A]": CURRENT})
    assert said.count(SAID) == 2 and "No motor position or speed was found" in said


def test_nothing_left_is_refused(tmp_path):
    trace = write_columns(tmp_path / "run.csv", {"time [s]": TIME, "speed [rad/s]": ZERO})
    with pytest.raises(InputError, match=r"run.csv: speed \[rad/s\]: never changes, and nothing else is left to read"):
        init(str(tmp_path / "m"), [trace])


def test_what_moves_in_one_recording_stays(tmp_path, capsys):
    held = {"speed [rad/s]": ZERO, "current [A]": CURRENT}
    said, _ = drafted(tmp_path, capsys, held, {"speed [rad/s]": SPEED, "current [A]": CURRENT})
    assert SAID not in said and "speed [rad/s] → speed" in said


def test_a_steady_speed_and_operating_points_at_rest_stay(tmp_path, capsys):
    steady = {"speed [rpm]": ZERO + 1000.0, "current [A]": CURRENT}
    assert SAID not in drafted(tmp_path, capsys, steady)[0]
    at_rest = {"speed [rpm]": ZERO, "angle [rad]": ANGLE, "current [A]": CURRENT}
    assert SAID not in drafted(tmp_path, capsys, at_rest, operating_points=True, force=True)[0]


def test_a_magnitude_beside_it_hides_nothing(tmp_path, capsys):
    said, _ = drafted(tmp_path, capsys, {"angle [rad]": ANGLE, "speed [rpm]": ZERO, "current [A]": np.abs(CURRENT)})
    assert f"speed [rpm]: {SAID}" in said
