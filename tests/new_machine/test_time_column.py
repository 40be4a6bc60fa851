"""The time column is known by its name, or by a unit of time if it goes in even steps."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.clock import is_uneven
from ema_twin_sim.new_machine.columns import guess_columns

POINTS = np.arange(1.0, 31.0)
SLIPS = 0.1 * 1.3**POINTS  # in uneven steps, as the load rises


@pytest.mark.parametrize("name", ["轉差 s", "slip [s]", "轉差[s]"])
def test_what_has_a_unit_of_time_but_goes_in_uneven_steps_is_no_clock(drafted, name):
    columns = {"轉速rpm": 3600.0 - 20.0 * POINTS, name: SLIPS, "電流A": 3.0 + 0.5 * POINTS}
    draft = drafted(columns)
    assert "電流A → current in A" in draft.said and "轉速rpm → speed in rpm" in draft.said
    assert "No time column was found: each row is read as an operating point" in draft.said
    assert "operating_points: true" in draft.map


@pytest.mark.parametrize(
    "name", ["時間 s", "时间s", "time [s]", "время [s]", "[s]", "tid [s]", "tijd", "czas [s]", "aika"]
)
def test_a_name_of_the_time_is_the_clock_however_it_goes(name):
    columns = {name: SLIPS, "電流A": POINTS}
    assert guess_columns(list(columns), numbers=columns).time.column == name


@pytest.mark.parametrize("name", ["轉差 s", "run [s]", "採樣ms"])
def test_a_unit_of_time_and_even_steps_are_a_clock(name):
    columns = {name: 0.5 * POINTS, "電流A": POINTS}
    assert guess_columns(list(columns), numbers=columns).time.column == name


@pytest.mark.parametrize("name", ["hora [s]", "axis [ms]", "採樣ms"])
def test_an_unknown_name_with_a_unit_of_time_is_assumed_to_be_the_clock(drafted, name):
    """Uneven steps alone, as of a logger that is late at times, made operating points of a motion."""
    factor = 1e3 if "ms" in name else 1.0
    time = np.cumsum(np.random.default_rng(1).choice([0.004, 0.03, 0.012], 2000))
    columns = {name: factor * time, "position [rad]": np.sin(time), "speed [rad/s]": np.cos(time)}
    columns["current [A]"] = np.cos(2.0 * time)
    guesses = guess_columns(list(columns), numbers=columns)
    assert guesses.time.column == name and not guesses.of_points
    draft = drafted(columns)
    assert f"{name}: taken for the time by its unit alone, though its steps are uneven" in draft.said
    assert "# CHECK: taken for the time" in draft.line("time")


def test_another_column_that_is_a_clock_comes_before_an_uneven_one():
    for clock in ("time [s]", "run [s]"):
        columns = {"hora [s]": SLIPS, clock: 0.5 * POINTS, "current [A]": POINTS}
        guesses = guess_columns(list(columns), numbers=columns)
        assert guesses.time.column == clock and guesses.time.doubt == ""


@pytest.mark.parametrize("name", ["slip [s]", "Schlupf [s]", "delay [ms]", "speed error [s]", "position [s]"])
def test_what_is_named_something_else_is_no_clock(name):
    columns = {name: SLIPS, "current [A]": POINTS}
    assert guess_columns(list(columns), numbers=columns).time is None


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rows", [0, 1, 2])
def test_fewer_than_two_steps_are_not_uneven(rows):
    assert not is_uneven(np.arange(float(rows)))


ROWS = np.arange(1.0, 201.0)
CLOCK = 0.002 * ROWS + 1e-4 * np.sin(ROWS)


@pytest.mark.parametrize("counter", ["timestep", "time_step", "Time Step", "timestamp"])
@pytest.mark.parametrize("clock", ["time", "t [s]", "Time (ms)", "run [s]"])
@pytest.mark.parametrize("first", [True, False])
def test_a_number_of_the_row_is_no_clock_beside_one(counter, clock, first):
    """It was read in ms since it came first, so that all speeds were wrong by a factor."""
    columns = {counter: ROWS, clock: CLOCK, "current [A]": np.sin(ROWS)}
    header = [*columns] if first else [clock, counter, "current [A]"]
    assert guess_columns(header, numbers=columns).time.column == clock


def test_a_number_of_the_row_is_read_in_place_of_a_clock_that_does_not_rise():
    for other in (np.zeros(200), CLOCK[::-1]):
        columns = {"timestep": ROWS, "time": other, "current [A]": np.sin(ROWS)}
        assert guess_columns(list(columns), numbers=columns).time.column == "timestep"


@pytest.mark.parametrize("name", ["timestep", "time", "t", "timestamp"])
def test_alone_it_is_the_clock(name):
    for numbers in (ROWS, ROWS - 1.0):
        columns = {name: numbers, "current [A]": np.sin(ROWS)}
        assert guess_columns(list(columns), numbers=columns).time.column == name


def test_a_time_in_steps_of_its_unit_is_no_number_of_the_row():
    columns = {"time [ms]": ROWS, "time stamp": CLOCK, "current [A]": np.sin(ROWS)}
    assert guess_columns(list(columns), numbers=columns).time.column == "time [ms]"


@pytest.mark.parametrize("before", ["MotorTest/", "log.", "/joint_states/", "drive data "])
def test_words_with_which_all_names_begin_do_not_hide_the_clock(before):
    """The program's name before each column made a motion a table of operating points."""
    columns = {f"{before}pos": np.sin(POINTS), f"{before}iq": POINTS % 3.0, f"{before}t": 0.5 * POINTS}
    assert guess_columns(list(columns), numbers=columns).time.column == f"{before}t"


def test_uneven_steps_of_a_clock_named_so_behind_other_words_are_no_doubt():
    columns = {"log/pos": np.sin(POINTS), "log/iq": POINTS % 3.0, "log/t_ms": SLIPS}
    time = guess_columns(list(columns), numbers=columns).time
    assert time.column == "log/t_ms" and not time.doubt


def test_a_symbol_of_time_behind_words_of_its_own_is_no_clock():
    columns = {"pos": np.sin(POINTS), "heat t": POINTS, "iq": POINTS % 3.0}
    assert guess_columns(list(columns), numbers=columns).time is None


@pytest.mark.parametrize(
    "before", ["timed run/", "time test ", "current log/", "Drehmoment_Test.", "speed_test/drive1/"]
)
@pytest.mark.parametrize(
    "names", [("motor position", "current", "t"), ("motor pos", "iq", "time [s]"), ("pos", "strom", "zeit")]
)
def test_quantities_with_which_all_names_begin_are_not_those_of_the_columns(before, names):
    position, current, clock = (f"{before}{name}" for name in names)
    columns = {position: np.sin(POINTS), current: POINTS % 3.0, clock: 0.5 * POINTS}
    guesses = guess_columns(list(columns), numbers=columns)
    assert guesses.time.column == clock
    assert {guess.signal: guess.column for guess in guesses.signals} == {"motor_position": position, "current": current}


def test_a_quantity_that_all_columns_give_is_theirs():
    columns = {"position motor": np.sin(POINTS), "position output": 0.1 * np.sin(POINTS)}
    assert {guess.signal for guess in guess_columns(list(columns)).signals} == {"motor_position", "output_position"}
    phases = ["current phase 1", "current phase 2", "current time"]
    assert [guess.signal for guess in guess_columns(phases).signals] == ["current"]
