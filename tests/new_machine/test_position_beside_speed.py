"""`init` with a position that is not the integral of the speed beside it."""

import numpy as np
import pytest

from ema_twin_sim.measured.way_by_speed import without_long_steps
from ema_twin_sim.new_machine.position_beside_speed import (
    going_with_speed,
    not_summed,
    share_beside_speed,
    unlike_speed,
)
from ema_twin_sim.new_machine.shaft import Shaft, position_shaft
from tests.recorded import sampled
from tests.taken_columns import guessed, taken

TIME = np.arange(2000) * 5e-3
SPEEDS = {
    "both ways": 40.0 * np.sin(1.3 * TIME) + 10.0 * np.sin(7.0 * TIME),
    "one way": 30.0 + 10.0 * np.sin(1.3 * TIME),
    "steps": 20.0 * np.sign(np.sin(0.9 * TIME)) * (1.0 + (TIME > 5.0)),
}
NOISE = np.random.default_rng(3).normal(size=len(TIME))


def recorded(speed, position):
    signals = {"speed": speed + 0.1 * NOISE, "motor_position": position - position[0]}
    return sampled("r", TIME, signals, motor_angle_origin=float(position[0]))


def way(speed):
    return np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(TIME))])


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("scale", [1.0, -1.0, 1e-3, 57.3])
def test_the_integral_of_the_speed_is_a_position_in_any_unit(name, scale):
    position = scale * (way(SPEEDS[name]) + 0.05 * NOISE)
    assert not_summed([recorded(SPEEDS[name], position)]) == unlike_speed([recorded(SPEEDS[name], position)]) == ""


@pytest.mark.parametrize("name", SPEEDS)
def test_what_goes_elsewhere_is_no_position(name):
    recording = recorded(SPEEDS[name], 60.0 * np.roll(NOISE, 700))
    assert "nothing in common" in unlike_speed([recording]) and not_summed([recording]) == ""


@pytest.mark.parametrize("name", ["both ways", "steps"])
@pytest.mark.parametrize("every", [1, 20])
def test_counts_since_the_last_sample_are_told_as_such(name, every):
    """Some loggers fetch them now and then only, and write zero in between."""
    counts = np.where(np.arange(len(TIME)) % every == 0, np.round(300.0 * np.diff(way(SPEEDS[name]), prepend=0.0)), 0.0)
    assert "counts since the last sample" in not_summed([recorded(SPEEDS[name], counts)])


@pytest.mark.parametrize("missing", [0, 1000])
def test_a_missing_sample_does_not_hide_that(missing):
    steps = np.diff(way(SPEEDS["both ways"]), prepend=0.0)
    steps[missing] = np.nan
    recording = sampled("r", TIME, {"speed": SPEEDS["both ways"] + 0.1 * NOISE, "motor_position": steps})
    assert "counts since the last sample" in not_summed([recording])


def test_a_position_that_stands_still_is_no_sum():
    assert not_summed([recorded(SPEEDS["one way"], np.full(len(TIME), 1234.0) + np.round(NOISE))]) == ""


def test_one_recording_that_shows_the_position_is_enough():
    good = recorded(SPEEDS["both ways"], way(SPEEDS["both ways"]))
    assert unlike_speed([recorded(SPEEDS["both ways"], 60.0 * np.roll(NOISE, 700)), good]) == ""


def test_init_leaves_it_out_and_says_so_once(drafted):
    speed = SPEEDS["both ways"]
    columns = {"time [s]": TIME, "motor position": np.round(60.0 * np.roll(NOISE, 700))}
    columns |= {"motor speed [rad/s]": speed + 0.1 * NOISE, "motor current [A]": np.sign(speed) + 0.1 * NOISE}
    draft = drafted(columns)
    assert "motor position: not used: it has nothing in common with the integral of the speed" in draft.said
    assert draft.said.count("motor position") == 1 and "motor_position" not in draft.map


def other_axis(size):
    """A position that drifts and swings with nothing of the speed's."""
    return size * (0.1 * TIME + np.sin(0.37 * TIME + 1.0) + 0.3 * np.sin(2.9 * TIME))


def positions(columns):
    """The position of motor and of output that `init` takes of these, and those of other axes."""
    found = taken(columns)
    axes = guessed(columns).other_axes
    return found.get("motor_position"), found.get("output_position"), axes


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_beside_a_speed_the_position_that_goes_with_it_is_the_machines(name, size):
    """Of a robot's angles, those of its body may go farther."""
    speed = SPEEDS[name] + 0.1 * NOISE
    leg = way(SPEEDS[name])
    columns = {"time [s]": TIME, "yaw angle": other_axis(size * np.ptp(leg)), "leg angle": leg, "speed": speed}
    assert positions(columns) == ("leg angle", None, ("yaw angle",))
    del columns["speed"]
    assert positions(columns)[2] == () and positions(columns)[0] == ("leg angle" if size < 1.0 else "yaw angle")


def test_two_shafts_of_one_train_go_with_the_speed_alike_and_travel_decides():
    motor = way(SPEEDS["both ways"])
    backlash = motor / 50.0 + 1e-3 * np.sign(SPEEDS["both ways"])
    columns = {"time [s]": TIME, "theta_one": backlash, "theta_two": motor, "yaw angle": other_axis(1e3)}
    columns["speed [rad/s]"] = SPEEDS["both ways"]
    assert positions(columns) == ("theta_two", "theta_one", ("yaw angle",))


def test_an_angle_that_starts_again_goes_with_the_speed_all_the_same():
    wrapped = np.degrees(way(SPEEDS["one way"])) % 360.0
    assert going_with_speed({"a": wrapped, "b": other_axis(1.0)}, SPEEDS["one way"], TIME) == {"a"}


def test_a_clock_that_goes_back_once_hides_nothing():
    time = np.concatenate([TIME[:700], TIME[:1300]])
    assert going_with_speed({"a": way(SPEEDS["steps"]), "b": other_axis(1.0)}, SPEEDS["steps"], time) == {"a"}


def test_without_any_that_goes_with_the_speed_all_are_possible():
    names = {"a": np.roll(NOISE, 700), "b": np.roll(NOISE, 300)}
    assert going_with_speed(names, SPEEDS["both ways"], TIME) == {*names}


def test_init_says_which_other_position_was_left_out(drafted):
    speed = SPEEDS["both ways"]
    columns = {"time [s]": TIME, "yaw [deg]": other_axis(1e3), "leg angle [rad]": way(speed)}
    columns |= {"speed [rad/s]": speed, "current [A]": np.sign(speed) + 0.1 * NOISE}
    draft = drafted(columns)
    assert "yaw [deg]: not used, since leg angle [rad] goes with the speed more" in draft.said
    assert "motor_position: {columns: ['leg angle \\[rad\\]']" in draft.map


def test_what_is_said_to_go_with_the_speed_more_is_the_motors_position(drafted):
    speed = SPEEDS["both ways"]
    columns = {"time [s]": TIME, "output angle [rad]": way(speed) / 3.0, "crank angle [rad]": way(speed)}
    columns |= {"tilt angle [rad]": other_axis(1.0), "speed [rad/s]": speed, "current [A]": np.gradient(speed, TIME)}
    told = drafted(columns).said
    assert "tilt angle [rad]: not used, since crank angle [rad] goes with the speed more" in told


def placed(share):
    """So many rows of all, as places."""
    return np.random.default_rng(8).permutation(np.arange(5, len(TIME) - 5, 3))[: round(share * len(TIME))]


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("size", [1e3, -1e6])
def test_single_wrong_values_hide_no_position(name, size):
    """They were most of its way, and it was said to have nothing in common with the speed."""
    position = way(SPEEDS[name]) + 1e-3 * NOISE
    position[placed(0.01)] += size
    assert unlike_speed([recorded(SPEEDS[name], position)]) == ""


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("lasting", [False, True])
def test_a_position_that_goes_with_the_speed_between_jumps_is_told_as_such(name, lasting):
    """As of a recording that is put together of pieces, or one with many wrong values."""
    jumps = np.zeros(len(TIME))
    jumps[placed(0.04)] = 1e3 * np.random.default_rng(9).normal(size=80)
    position = way(SPEEDS[name]) + (np.cumsum(jumps) if lasting else jumps)
    told = unlike_speed([recorded(SPEEDS[name], position)])
    assert "it jumps farther than the speed goes" in told and "nothing in common" not in told
    count = int(told.split("in ")[1].split(" of ")[0])
    assert (70 <= count <= 80) if lasting else (140 <= count <= 160)


@pytest.mark.parametrize("name", SPEEDS)
def test_what_goes_elsewhere_between_its_jumps_has_nothing_in_common(name):
    jumps = np.zeros(len(TIME))
    jumps[placed(0.04)] = 1e3 * np.random.default_rng(9).normal(size=80)
    position = 60.0 * np.roll(NOISE, 700) + jumps
    assert "nothing in common" in unlike_speed([recorded(SPEEDS[name], position)])


@pytest.mark.parametrize(("unit", "per_second"), [("rad", "rad/s"), ("m", "m/s")])
def test_a_factor_between_both_is_told_of_a_shaft_and_of_a_carriage(unit, per_second, drafted):
    """A time of twice the length: a shaft may have a gear of that ratio, a carriage has none."""
    speed = SPEEDS["both ways"]
    torque = {"rad": "torque [N m]", "m": "force [N]"}[unit]
    run = {f"position [{unit}]": 0.5 * way(speed), f"speed [{per_second}]": speed, torque: np.sign(speed)}
    asked = {"rad": "without a gear a unit, or the time, is wrong by that factor", "m": "Are the units of both right?"}
    draft = drafted({"time [s]": TIME, **run})
    assert "changes 0.5 times as much as the integral of the speed" in draft.map and asked[unit] in draft.map
    right = drafted({"time [s]": TIME, **run, f"position [{unit}]": way(speed)})
    assert "times as much as the integral" not in right.map


@pytest.mark.parametrize("missing", [[], [400, 800, 1200], [399, 799, 1199], [400, 401, 799, 800, 801]])
def test_turns_lost_in_pauses_are_no_gear(missing):
    """A controller records each speed for 2 s and then waits 1 s; its angle starts again after each turn.

    Single values beside the pauses may be missing.
    """
    time = np.concatenate([3.0 * k + np.arange(0.0, 2.0, 5e-3) for k in range(8)])
    speed = np.repeat([14.0, 14.0, 14.0, 9.0, 5.0, -5.0, -9.0, -14.0], 400) + 0.05 * np.resize(NOISE, len(time))
    went = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    counted = np.unwrap(np.mod(went, 2.0 * np.pi))
    assert np.abs(counted - went).max() > 2.0 * np.pi
    counted[missing] = np.nan
    (left,) = without_long_steps(time, 0.5, counted)
    assert np.nanmax(np.abs(np.diff(left[np.isfinite(left)]))) < 0.5
    recording = sampled("r", time, {"speed": speed, "motor_position": counted})
    assert position_shaft(recording, None, units_known=True) == Shaft()
    assert share_beside_speed([recording]) < 0.02 and unlike_speed([recording]) == ""


def test_units_are_found_beside_pauses(drafted):
    """The same, of columns without units: both in degrees, though the angle lost turns in the pauses."""
    time = np.concatenate([3.0 * k + np.arange(0.0, 2.0, 5e-3) for k in range(8)])
    speed = np.repeat([900.0, 900.0, 900.0, 500.0, 300.0, -300.0, -500.0, -900.0], 400) + 3.0 * np.resize(NOISE, 3200)
    went = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    draft = drafted({"t [s]": time, "angle": np.round(np.mod(went, 360.0), 3), "vel": np.round(speed, 3)})
    assert "vel → speed in deg/s angle → motor_position in deg" in draft.said
    assert "gear ratio 1 (give" in draft.said and "of the same shaft" not in draft.said
