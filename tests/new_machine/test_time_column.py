"""The time column is known by its name, or by a unit of time if it goes in even steps."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.clock import is_uneven
from tests.taken_columns import guessed, signals, taken

POINTS = np.arange(1.0, 31.0)
SLIPS = 0.1 * 1.3**POINTS  # in uneven steps, as the load rises


@pytest.mark.parametrize("name", ["轉差 s", "slip [s]", "轉差[s]"])
def test_what_has_a_unit_of_time_but_goes_in_uneven_steps_is_no_clock(drafted, name):
    columns = {"轉速rpm": 3600.0 - 20.0 * POINTS, name: SLIPS, "電流A": 3.0 + 0.5 * POINTS}
    draft = drafted(columns)
    assert "電流A → current in A" in draft.said and "轉速rpm → speed in rpm" in draft.said
    assert "No time column was found: each row is read as an operating point" in draft.said
    assert "operating_points: true" in draft.map


def clock(columns):
    """The name of the column that is taken for the time; None if none is."""
    time = guessed(columns).time
    return None if time is None else time.column


ROWS = np.arange(1.0, 201.0)
CALLED = ["時間 s", "时间s", "time [s]", "время [s]", "[s]", "tid [s]", "tijd", "czas [s]", "aika"]
CALLED_OTHERWISE = ["slip [s]", "Schlupf [s]", "delay [ms]", "speed error [s]", "position [s]"]


@pytest.mark.parametrize(
    ("name", "time", "found"),
    [
        *((name, SLIPS, True) for name in CALLED),  # however it goes
        *((name, SLIPS, False) for name in CALLED_OTHERWISE),
        *((name, 0.5 * POINTS, True) for name in ("轉差 s", "run [s]", "採樣ms")),  # a unit of time, and even steps
        *((name, ROWS - k, True) for name in ("timestep", "time", "t", "timestamp") for k in (0.0, 1.0)),
    ],
)
def test_one_column_beside_a_current(name, time, found):
    assert clock({name: time, "電流A": np.sin(time)}) == (name if found else None)


@pytest.mark.parametrize("name", ["hora [s]", "axis [ms]", "採樣ms"])
def test_an_unknown_name_with_a_unit_of_time_is_assumed_to_be_the_clock(drafted, name):
    """Uneven steps alone, as of a logger that is late at times, made operating points of a motion."""
    factor = 1e3 if "ms" in name else 1.0
    time = np.cumsum(np.random.default_rng(1).choice([0.004, 0.03, 0.012], 2000))
    columns = {name: factor * time, "position [rad]": np.sin(time), "speed [rad/s]": np.cos(time)}
    columns["current [A]"] = np.cos(2.0 * time)
    guesses = guessed(columns)
    assert guesses.time.column == name and not guesses.of_points
    draft = drafted(columns)
    assert f"{name}: taken for the time by its unit alone, though its steps are uneven" in draft.said
    assert "# CHECK: taken for the time" in draft.line("time")


@pytest.mark.parametrize("even", ["time [s]", "run [s]"])
def test_another_column_that_is_a_clock_comes_before_an_uneven_one(even):
    time = guessed({"hora [s]": SLIPS, even: 0.5 * POINTS, "current [A]": POINTS}).time
    assert time.column == even and time.doubt == ""


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rows", [0, 1, 2])
def test_fewer_than_two_steps_are_not_uneven(rows):
    assert not is_uneven(np.arange(float(rows)))


CLOCK = 0.002 * ROWS + 1e-4 * np.sin(ROWS)


@pytest.mark.parametrize("counter", ["timestep", "time_step", "Time Step", "timestamp"])
@pytest.mark.parametrize("clock_name", ["time", "t [s]", "Time (ms)", "run [s]"])
@pytest.mark.parametrize("first", [True, False])
def test_a_number_of_the_row_is_no_clock_beside_one(counter, clock_name, first):
    """It was read in ms since it came first, so that all speeds were wrong by a factor."""
    columns = {counter: ROWS, clock_name: CLOCK, "current [A]": np.sin(ROWS)}
    assert clock(columns if first else dict(reversed(columns.items()))) == clock_name


@pytest.mark.parametrize("other", [np.zeros(200), CLOCK[::-1]])
def test_a_number_of_the_row_is_read_in_place_of_a_clock_that_does_not_rise(other):
    assert clock({"timestep": ROWS, "time": other, "current [A]": np.sin(ROWS)}) == "timestep"


def test_a_time_in_steps_of_its_unit_is_no_number_of_the_row():
    assert clock({"time [ms]": ROWS, "time stamp": CLOCK, "current [A]": np.sin(ROWS)}) == "time [ms]"


@pytest.mark.parametrize("before", ["MotorTest/", "log.", "/joint_states/", "drive data "])
def test_words_with_which_all_names_begin_do_not_hide_the_clock(before):
    """The program's name before each column made a motion a table of operating points."""
    columns = {f"{before}pos": np.sin(POINTS), f"{before}iq": POINTS % 3.0, f"{before}t": 0.5 * POINTS}
    assert clock(columns) == f"{before}t"


def test_uneven_steps_of_a_clock_named_so_behind_other_words_are_no_doubt():
    time = guessed({"log/pos": np.sin(POINTS), "log/iq": POINTS % 3.0, "log/t_ms": SLIPS}).time
    assert time.column == "log/t_ms" and not time.doubt


def test_a_symbol_of_time_behind_words_of_its_own_is_no_clock():
    assert clock({"pos": np.sin(POINTS), "heat t": POINTS, "iq": POINTS % 3.0}) is None


@pytest.mark.parametrize(
    "before", ["timed run/", "time test ", "current log/", "Drehmoment_Test.", "speed_test/drive1/"]
)
@pytest.mark.parametrize(
    "names", [("motor position", "current", "t"), ("motor pos", "iq", "time [s]"), ("pos", "strom", "zeit")]
)
def test_quantities_with_which_all_names_begin_are_not_those_of_the_columns(before, names):
    position, current, time = (f"{before}{name}" for name in names)
    columns = {position: np.sin(POINTS), current: POINTS % 3.0, time: 0.5 * POINTS}
    assert clock(columns) == time and taken(columns) == {"motor_position": position, "current": current}


def test_a_quantity_that_all_columns_give_is_theirs():
    assert {*signals("position motor", "position output").values()} == {"motor_position", "output_position"}
    assert [*signals("current phase 1", "current phase 2", "current time").values()] == ["current"]
