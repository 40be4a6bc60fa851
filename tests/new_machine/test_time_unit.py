"""The unit of a clock that names none: by dates, by the motion, by counting from 1970, by fractions, by its steps."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.new_machine.time_unit import time_unit
from ema_twin_sim.new_machine.units_by_numbers import with_units
from tests.taken_columns import guessed

PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
COUNT = np.arange(600)


def moved(seconds):
    """(angle [rad], speed [rad/s]) of a motor that swings slowly."""
    return 30.0 * np.sin(0.3 * seconds), 9.0 * np.cos(0.3 * seconds)


def written(clock, angle):
    return {"timestamp": clock, "position [rad]": angle, "torque [Nm]": np.cos(angle)}


@pytest.mark.parametrize("date", ["2025-11-09T", "2025-11-09 ", ""])
@pytest.mark.parametrize("period", [0.101, 0.25, 0.01])
def test_a_date_and_a_time_of_day_are_in_seconds_and_leave_nothing_to_check(drafted, date, period):
    seconds = COUNT * period
    clock = [f"{date}09:{27 + int(t) // 60:02d}:{t % 60:06.3f}" for t in seconds]
    line = drafted(written(clock, moved(seconds)[0])).line("time")
    assert "unit: s}" in line and "CHECK" not in line


@pytest.mark.parametrize("unit", PER_SECOND)
@pytest.mark.parametrize("period", [2e-4, 0.02, 0.5])
def test_a_time_since_1970_tells_its_unit_by_its_size(unit, period):
    assert time_unit((1.75e9 + COUNT * period) * PER_SECOND[unit])[0] == unit


@pytest.mark.parametrize(("unit", "began"), [("us", 1.7e9), ("ns", 1.7e12), ("ns", 1.7e15)])
def test_a_counter_of_a_small_unit_that_is_as_large_does_not_count_from_1970(unit, began):
    """A controller that has run for half an hour, or for weeks."""
    assert time_unit(began + np.rint(COUNT * 1e-3 * PER_SECOND[unit]))[0] == unit


@pytest.mark.parametrize("names", [("angle [rad]", "speed [rad/s]"), ("angle [rad]", "speed"), ("angle", "speed")])
@pytest.mark.parametrize("unit", PER_SECOND)
@pytest.mark.parametrize("period", [5e-4, 0.02, 0.2, 0.5])
def test_where_position_and_speed_agree_they_tell_the_unit(names, unit, period):
    """Also of half milliseconds, and of five samples a second."""
    seconds = COUNT * period
    columns = dict(zip(("time", *names), (seconds * PER_SECOND[unit], *moved(seconds)), strict=True))
    found = with_units(guessed(columns), columns, None)
    assert found.time.unit == unit
    assert {guess.unit for guess in found.signals} == {"rad", "rad/s"}


@pytest.mark.parametrize("period", [0.101, 0.2, 0.5])
def test_fractions_are_of_seconds_and_it_is_said_that_this_was_assumed(drafted, period):
    seconds = COUNT * period
    draft = drafted(written(np.round(seconds, 5), moved(seconds)[0]))
    assert "unit: s}" in draft.line("time") and "CHECK" in draft.line("time")
    assert "timestamp in s: no unit in the header" in draft.said


@pytest.mark.parametrize(("step", "unit"), [(1e-3, "s"), (0.1, "s"), (1.0, "ms"), (5.0, "ms"), (1000.0, "us")])
def test_a_counter_is_taken_in_the_largest_unit_of_a_drive(step, unit):
    assert time_unit(COUNT * step)[0] == unit


def test_milliseconds_that_jitter_about_one_are_no_seconds():
    assert time_unit(np.cumsum(np.random.default_rng(1).uniform(0.98, 1.01, 600)))[0] == "ms"


@pytest.mark.filterwarnings("error")
def test_a_recording_of_one_row_is_refused_without_a_word_of_its_clock(drafted):
    with pytest.raises(InputError, match="has one row only"):
        drafted({"time": ["1720085517763847700"], "position [rad]": [0.5], "current [A]": [0.1]})


@pytest.mark.parametrize("period", [0.01, 1.0])
def test_a_clock_whose_unit_makes_the_samples_slow_is_asked_about(drafted, period):
    """Milliseconds that are called seconds make speeds, inertia and delays wrong, and nothing else shows."""
    columns = {"time [s]": COUNT * period, "position [rad]": moved(COUNT * 0.01)[0], "torque [Nm]": np.cos(COUNT)}
    asked = "samples come every 1 s by column 'time [s]', more slowly than most drives are recorded: is it in ms"
    assert (asked in drafted(columns).warned) == (period == 1.0)


def test_a_slow_clock_by_which_position_and_speed_agree_is_right(drafted):
    seconds = COUNT * 0.5
    position, speed = 30.0 * np.sin(0.05 * seconds), 1.5 * np.cos(0.05 * seconds)
    columns = {"time [s]": seconds, "position [rad]": position, "speed [rad/s]": speed, "torque [Nm]": np.cos(position)}
    assert "samples come every" not in drafted(columns).warned
