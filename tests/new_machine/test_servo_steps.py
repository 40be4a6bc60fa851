"""Servos that log whole steps of their own: names and motion tell which; the map holds the size of each step."""

import numpy as np
import pytest

from ema_bench_replay.traces.header_words import COUNTS
from ema_twin_sim.new_machine.units_by_numbers import with_units
from tests.taken_columns import guessed

TIME = np.arange(2000) * 0.01
SPEED = 2.0 * np.sin(1.9 * TIME) + 0.8 * np.sin(0.4 * TIME)  # rad/s
ANGLE = 2.0 / 1.9 * (1.0 - np.cos(1.9 * TIME)) + 2.0 * (1.0 - np.cos(0.4 * TIME))  # rad
CURRENT = 0.3 * np.sign(SPEED) + 0.2 * np.cos(1.9 * TIME)  # A
RPM = 30.0 / np.pi


def logged(step_of_speed=0.229, step_of_current=2.69, word="present"):
    """Time [s] and whole steps of position, speed [rpm] and current [mA], under the names of the control table."""
    steps = (ANGLE * 4096 / (2.0 * np.pi), SPEED * RPM / step_of_speed, CURRENT * 1e3 / step_of_current)
    names = [f"{word}_{quantity}" for quantity in ("position", "velocity", "current")]
    return {"time [s]": TIME, **{name: np.rint(values) for name, values in zip(names, steps, strict=True)}}


def measured(columns):
    """What each signal is taken from, with the units that the numbers tell."""
    return with_units(guessed(columns), columns, None).by_signal


@pytest.mark.parametrize(("step_of_speed", "of_current"), [(0.229, 2.69), (60.0 / 4096.0, 6.5)])
def test_the_motion_tells_which_servo_it_is(step_of_speed, of_current):
    found = measured(logged(step_of_speed))
    assert (found["motor_position"].unit, found["motor_position"].counts) == (COUNTS, 4096.0)
    assert (found["speed"].unit, found["speed"].factor) == ("rpm", pytest.approx(step_of_speed))
    assert (found["current"].unit, found["current"].factor) == ("mA", of_current)
    assert all(guess.doubt for guess in found.values())


def test_a_commanded_speed_in_the_same_steps_is_read_like_the_measured_one():
    columns = logged()
    found = measured({**columns, "goal_velocity": columns["present_velocity"]})
    assert found["speed_setpoint"].factor == 0.229


@pytest.mark.parametrize("of_another", [{"word": "actual"}, {"step_of_speed": 0.4}])
def test_other_names_or_another_motion_are_of_no_such_servo(of_another):
    assert all(guess.factor == 1.0 for guess in measured(logged(**of_another)).values())


@pytest.mark.parametrize("size", [1.0, 8.0])
def test_whole_numbers_without_a_unit_are_asked_about(size, drafted):
    """Without a speed nothing tells what a step is; as radians they would be an encoder of six counts, or fewer."""
    steps = size * np.rint(ANGLE * 4096 / (2.0 * np.pi * size))
    said = drafted({"time [s]": TIME, "position": steps, "current [A]": CURRENT}).warned
    assert f"motor_position goes in steps of {size:g} rad" in said and "counts_per_revolution" in said


def test_whole_numbers_with_a_unit_are_not_asked_about(drafted):
    columns = {"time [s]": TIME, "position [deg]": np.rint(np.degrees(ANGLE)), "current [A]": CURRENT}
    assert "counts_per_revolution" not in drafted(columns).warned


@pytest.mark.parametrize(("turned", "asked"), [(4096.0 / (2.0 * np.pi), True), (1.0, False)])
def test_a_position_faster_than_motors_turn_is_asked_about(turned, asked, drafted):
    """A drive's estimate between two counts goes in no steps; read as radians, the motor would turn too fast."""
    way = 20.0 * (TIME + np.sin(TIME)) + 1e-4 * np.random.default_rng(3).standard_normal(len(TIME))
    columns = {"time [s]": TIME, "pos": turned * way, "current [A]": CURRENT}
    assert ("faster than most motors turn" in drafted(columns).warned) is asked


def test_decimals_are_no_steps():
    columns = logged()
    found = measured({**columns, "present_position": columns["present_position"] + 0.25})
    assert found["motor_position"].counts is None and found["speed"].factor == 1.0


def test_the_map_of_init_reads_radians_and_amperes(drafted, read):
    said = drafted(logged()).said
    assert "present_velocity → speed in steps of 0.229 rpm" in said and "DYNAMIXEL X" in said
    signals = read().signals
    assert np.ptp(signals["motor_position"]) == pytest.approx(np.ptp(ANGLE), abs=2e-3)
    assert signals["speed"] == pytest.approx(SPEED, abs=0.013)
    assert signals["current"] == pytest.approx(CURRENT, abs=1.4e-3)
