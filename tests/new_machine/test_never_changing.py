"""What never changes shows no motion, or no drive: `init` says so, leaves it out, and learns nothing else of it."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError

TIME = np.arange(600) * 2e-3
SPEED = 40.0 * np.sin(6.0 * TIME)
ANGLE = 40.0 / 6.0 * (1.0 - np.cos(6.0 * TIME))
CURRENT = 0.3 * np.sign(SPEED) + 0.24 * np.cos(6.0 * TIME) + 1e-3 * np.random.default_rng(1).standard_normal(600)
ZERO = np.zeros(600)
SAID = "not used, since it never changes"


@pytest.fixture
def timed(drafted):
    return lambda *runs, **options: drafted(*({"time [s]": TIME, **run} for run in runs), **options)


@pytest.mark.parametrize("still", ["speed [rpm]", "output position [rad]"])
def test_what_is_left_works(timed, still):
    draft = timed({"angle [rad]": ANGLE, still: ZERO, "current [A]": CURRENT})
    for words in (f"{still}: {SAID}", "angle [rad] → motor_position", "ema-twin discover"):
        assert words in draft.said
    assert "speed:" not in draft.map and "output_position:" not in draft.map and f"# not used: {still}" in draft.map


def test_a_position_that_stands_beside_a_speed(timed):
    said = timed({"angle [rad]": ZERO + 1.5, "speed [rad/s]": SPEED, "current [A]": CURRENT}).said
    assert "angle [rad]: not used: it stands still, while by the speed the motor moves" in said
    assert "speed [rad/s] → speed" in said


def test_another_column_that_changes_is_taken(timed):
    rpm = SPEED * 30.0 / np.pi
    run = {"electrical speed (RPM)": ZERO, "optical speed (RPM)": rpm, "current [A]": CURRENT}
    draft = timed(run)
    assert "optical speed (RPM) → speed" in draft.said
    assert "electrical speed" not in draft.map.partition("# not used")[0]


@pytest.mark.parametrize("drive", ["effort [N m]", "current [A]"])
def test_a_drive_that_is_zero_all_along_is_none(timed, drive):
    """As the efforts of joint states are that nobody fills in."""
    run = {"angle [rad]": ANGLE, "speed [rad/s]": SPEED, drive: ZERO}
    draft = timed(run)
    assert f"{drive}: {SAID}" in draft.said and "No current or torque was found" in draft.said
    assert "current:" not in draft.map and "motor_torque: {columns: ['effort" not in draft.map
    said = timed(run, {**run, drive: CURRENT}).said
    assert SAID not in said and f"{drive} → " in said


def test_a_length_that_never_changes_makes_no_machine_linear(timed):
    """The arm of a brake; by its words it is no position either."""
    run = {"Moment arm (cm)": ZERO + 15.25, "lever (mm)": ZERO + 3.0, "speed [rad/s]": SPEED, "current [A]": CURRENT}
    draft = timed(run)
    assert "speed [rad/s] → speed" in draft.said and "motion: linear" not in draft.map
    moved = {"Moment arm (cm)": 15.0 + ANGLE, "speed [rad/s]": SPEED, "current [A]": CURRENT}
    assert "speed [rad/s] → speed" in timed(moved).said


def test_without_any_motion_that_is_said(timed):
    said = timed({"angle [rad]": ZERO, "speed [rad/s]": ZERO, "current [A]": CURRENT}).said
    assert said.count(SAID) == 2 and "No motor position or speed was found" in said


def test_nothing_left_is_refused(timed):
    with pytest.raises(InputError, match=r"run0.csv: speed \[rad/s\]: never changes, and nothing else is left to read"):
        timed({"speed [rad/s]": ZERO})


def test_what_moves_in_one_recording_stays(timed):
    held = {"speed [rad/s]": ZERO, "current [A]": CURRENT}
    said = timed(held, {"speed [rad/s]": SPEED, "current [A]": CURRENT}).said
    assert SAID not in said and "speed [rad/s] → speed" in said


def test_a_steady_speed_and_operating_points_at_rest_stay(timed):
    steady = {"speed [rpm]": ZERO + 1000.0, "current [A]": CURRENT}
    assert SAID not in timed(steady).said
    at_rest = {"speed [rpm]": ZERO, "angle [rad]": ANGLE, "current [A]": CURRENT}
    assert SAID not in timed(at_rest, operating_points=True).said


def test_a_magnitude_beside_it_hides_nothing(timed):
    columns = {"angle [rad]": ANGLE, "speed [rpm]": ZERO, "current [A]": np.abs(CURRENT)}
    assert f"speed [rpm]: {SAID}" in timed(columns).said


def test_a_torque_of_zeros_gives_way_to_one_that_changes(timed):
    run = {"angle [rad]": ANGLE, "motor torque [N m]": ZERO, "torque [N m]": CURRENT}
    assert "torque [N m] → motor_torque" in timed(run).said


def test_a_steady_temperature_is_the_motors_all_the_same(timed):
    drifting = 40.0 + 1e-3 * np.arange(600)
    run = {"angle [rad]": ANGLE, "current [A]": CURRENT, "motor temperature [°C]": ZERO + 25.0}
    assert "motor temperature [°C] → temperature" in timed({**run, "board temperature [°C]": drifting}).said


def test_a_carriage_that_is_held_is_linear(timed):
    run = {"position [mm]": ZERO + 3.0, "speed [mm/s]": ZERO, "force [N]": CURRENT}
    assert "motion: linear" in timed(run).map


def test_points_without_a_unit_are_not_asked_about_an_encoders_steps(drafted):
    points = {"position": np.repeat([0.0, 10.0, 20.0, 10.0, 40.0], 4), "current [A]": np.tile([0.1, 0.4, 0.7, 1.0], 5)}
    assert "counts_per_revolution" not in drafted(points, operating_points=True).told
