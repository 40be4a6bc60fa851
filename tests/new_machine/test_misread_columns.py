"""Columns that `init` once took for something else: numbered names, clocks that step back, units of another motion."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.header_words import COUNTS, header_words
from ema_twin_sim.new_machine.column_quantity import contradicted_quantity
from ema_twin_sim.new_machine.columns import guess_columns
from tests.trace_text import write_columns

TIME = np.arange(400) * 2e-3
SPEED = 150.0 * np.sin(5.0 * TIME)
CURRENT = 0.5 * np.sign(SPEED) + 0.2 * np.cos(5.0 * TIME)


def test_steps_are_counts_only_where_a_unit_stands():
    assert header_words("motor position [steps]").unit == COUNTS
    assert header_words("step").unit is None and header_words("time step").unit is None


def test_a_clock_of_that_name_and_unit_is_the_clock_though_it_steps_back(drafted):
    time = TIME.copy()
    time[0] = time[1] + 5e-4
    columns = {"Time (s)": time, "ESC signal (µs)": 1000.0 + np.arange(len(TIME)), "speed [rad/s]": SPEED}
    with pytest.raises(InputError, match=r"line 3: column 'Time \(s\)': time goes back .* first row .* remove line 2"):
        drafted({**columns, "current [A]": CURRENT})


def test_a_single_repeated_time_is_said_and_left_out(drafted):
    time = TIME.copy()
    time[1] = time[0]
    columns = {"Time (s)": time, "ESC signal (µs)": 1000.0 + 0.5 * np.arange(len(TIME)), "speed [rad/s]": SPEED}
    draft = drafted({**columns, "current [A]": CURRENT})
    assert "1 row (the first in line 3) tells the time of the row before: left out" in draft.warned
    assert "column: 'Time \\(s\\)'" in draft.map


def test_a_table_whose_time_goes_back_may_be_of_operating_points(drafted):
    columns = {"time [s]": [3.0, 1.0, 2.0, 5.0, 4.0, 6.0], "speed [rad/s]": np.arange(6.0), "torque [N m]": np.ones(6)}
    with pytest.raises(InputError, match=r"time goes back .* give --operating-points"):
        drafted(columns)
    assert "operating_points: true" in drafted(columns, operating_points=True).map


def test_long_samples_whose_time_goes_back_are_no_operating_points(drafted):
    columns = {"time [s]": np.tile(TIME, 2), "speed [rad/s]": np.tile(SPEED, 2), "current [A]": np.tile(CURRENT, 2)}
    with pytest.raises(InputError, match="time goes back") as refused:
        drafted(columns)
    assert "operating" not in str(refused.value)


def test_a_motor_that_turns_is_of_a_rotary_machine_whatever_the_unit_of_its_torque(drafted):
    columns = {"time [s]": TIME, "motor speed [rpm]": SPEED, "motor torque [mN]": CURRENT, "motor current [A]": CURRENT}
    draft = drafted(columns)
    assert "motor torque [mN]: mN is a unit of a linear machine" in draft.said
    assert "motor speed [rpm] → speed in rpm" in draft.said and "motion: linear" not in draft.map


def test_a_carriage_is_linear_whatever_its_encoder_counts():
    guesses = guess_columns(["t", "position [mm]", "speed [rev/s]", "force [N]"])
    assert guesses.motion == "linear" and guesses.other_motion == ("speed [rev/s]",)


def test_of_two_lines_of_names_the_one_with_units_is_the_header(tmp_path, drafted):
    points = np.arange(1.0, 31.0)
    columns = {"轉速rpm": 3600.0 - points, "轉矩n-m": points, "Q功率VAR": 9.0 - points}
    trace = write_columns(tmp_path / "points.csv", columns)
    trace.write_text("speed,torque,Q3\n" + trace.read_text())
    told = drafted(trace).said
    assert "轉矩n-m → motor_torque in N m" in told and "轉速rpm → speed in rpm" in told and "VAR →" not in told


def walking():
    """Position and speed of a joint that swings and is hit at each stride: then its speed changes much in one row."""
    time = np.arange(1500) * 0.01
    angle, speed = 0.2 * np.sin(3.0 * time), 0.6 * np.cos(3.0 * time)
    for hit in np.arange(0.35, time[-1], 0.53):
        away = (time - hit) / 0.025
        angle += 0.1 * np.exp(-0.5 * away**2)
        speed -= 0.1 * away / 0.025 * np.exp(-0.5 * away**2)
    return angle, speed


def test_samples_of_a_fast_motion_without_a_time_are_no_operating_points(drafted):
    """The way from row to row is that of both their speeds; that of one of them alone was too far off."""
    angle, speed = walking()
    columns = {"joint pos [rad]": angle, "joint vel [rad/s]": speed, "tau [N m]": 3.0 * np.sin(angle) + np.sign(speed)}
    with pytest.raises(InputError, match=r"look like samples; export the time too, in a column named 'time \[s\]'"):
        drafted(columns)


@pytest.mark.parametrize("names", [("tau_cal", "tau_est"), ("calculated torque", "torque")])
def test_what_the_drive_reports_is_preferred_to_what_a_controller_computed(names):
    computed, reported = names
    angle, speed = walking()
    columns = {"time [s]": np.arange(len(angle)) * 0.01, f"{computed} [N m]": np.cos(angle)}
    columns |= {f"{reported} [N m]": np.sin(angle), "joint pos [rad]": angle, "joint vel [rad/s]": speed}
    guesses = {guess.signal: guess.column for guess in guess_columns(list(columns)).signals}
    assert guesses["motor_torque"] == f"{reported} [N m]"


@pytest.mark.parametrize(
    ("columns", "signal", "column"),
    [
        (("current [A]", "torque [N m]", "calculated motor torque [N m]"), "motor_torque", "calculated motor torque"),
        (("torque raw [N m]", "torque cal [N m]"), "motor_torque", "torque raw"),
        (("valve torque [N m]", "position [rad]"), "motor_torque", "valve torque"),
    ],
)
def test_words_of_a_part_or_a_calculation_say_nothing_of_other_quantities(columns, signal, column):
    guesses = {guess.signal: guess for guess in guess_columns(["time [s]", *columns]).signals}
    assert guesses[signal].column.startswith(column) and guesses[signal].shaft != "output"


def test_a_pedal_that_a_driver_sets_is_not_the_output_of_a_throttle(drafted):
    time = np.arange(3000) * 2e-3
    throttle = np.sin(3.0 * time)
    columns = {
        "time [s]": time,
        "pedal position [deg]": 20.0 * np.sin(1.1 * time) ** 3,
        "throttle position [deg]": 40.0 * throttle,
        "current [A]": throttle + np.sign(np.cos(3.0 * time)),
    }
    text = drafted(columns).map
    assert "throttle position" in text and "# not used: pedal position [deg]" in text


def test_a_position_that_no_usual_units_make_the_integral_of_its_speed_is_asked_about(drafted):
    time = np.arange(1500) * 2e-3
    speed = 40.0 * np.sin(6.0 * time)
    angle = 10.0 * 40.0 / 6.0 * (1.0 - np.cos(6.0 * time))
    columns = {"time [s]": time, "position": angle, "velocity": speed, "current [A]": 0.3 * np.sign(speed)}
    said = drafted(columns).said
    assert "it changes 10 times as much as the integral of the speed: what are the units of both?" in said
    columns = {"position [deg]" if name == "position" else name: values for name, values in columns.items()}
    assert "speed: the position changes 10 times as much as the integral of the speed, which no usual unit" in (
        drafted(columns).said
    )


def test_counts_that_would_be_usual_with_another_unit_of_the_speed_are_asked_about(drafted):
    """8192 counts, and a speed in rpm whose name says rad/s."""
    time = np.arange(1500) * 2e-3
    speed, angle = 40.0 * np.sin(6.0 * time), 40.0 / 6.0 * (1.0 - np.cos(6.0 * time))
    columns = {"time [s]": time, "position [counts]": np.rint(angle * 8192 / (2.0 * np.pi))}
    columns |= {"speed [rad/s]": speed * 30.0 / np.pi, "current [A]": 0.3 * np.sign(speed)}
    told = drafted(columns).told
    assert "8192 is, which it would be with the speed in rpm: is rad/s right?" in told


def test_a_unit_that_the_header_tells_is_not_asked_about(drafted):
    """A speed in steps a second was asked whether it is in rpm."""
    speed = 900.0 + 4000.0 * np.sin(5.0 * TIME) ** 2
    for name, asked in (("Speed (steps/s)", False), ("Speed", True), ("Speed (1)", True)):
        draft = drafted({"time [s]": TIME, "current [A]": CURRENT, name: speed})
        assert ("is its column in rpm, and read as rad/s?" in draft.warned) is asked
        assert ("'steps/s' is not a unit of the speed" in draft.warned) is not asked


def test_a_word_contradicts_a_unit_that_is_told_of_it():
    assert contradicted_quantity("encoder_V", "V") == "position" and contradicted_quantity("encoder_V") == ""
