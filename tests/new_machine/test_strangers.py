"""The first hour of a stranger: a CSV in their own words and units, `init`, `discover`, and nothing edited."""

import math

import numpy as np
import pytest

from ema_twin_sim.new_machine.columns import guess_columns
from ema_twin_sim.new_machine.told import assumed_units
from ema_twin_sim.new_machine.turns import counted_on_turns
from ema_twin_sim.new_machine.units_by_numbers import with_units
from ema_twin_sim.new_machine.usual_counts import usual_counts
from tests.accuracy.strangers.cases import mistaken_cases, stranger_cases
from tests.accuracy.strangers.judge import answered
from tests.accuracy.strangers.words import BESIDE, QUANTITY, UNITS, named, spelt, with_unit
from tests.command_line import done, twin
from tests.taken_columns import guessed, taken

PLACES = ("[]", "()", "/", "tight", "in", ",", "_")


@pytest.mark.parametrize("language", ["english", "german", "symbols"])
def test_columns_are_known_in_other_peoples_words(language):
    random = np.random.default_rng(17)
    for _ in range(300):
        drive = str(random.choice(["current", "motor_torque"]))
        others = [name for name in ("speed", "speed_setpoint", "output_position") if random.random() < 0.6]
        truth = {}
        for signal in ("time", "motor_position", drive, *others):
            unit = str(random.choice(list(UNITS[QUANTITY[signal]])))
            spelling = spelt(unit, QUANTITY[signal], language, random)
            name = with_unit(named(signal, language, random), spelling, str(random.choice(PLACES)))
            truth[signal] = name, unit
        beside = [str(name) for name in random.choice(list(BESIDE), 2, replace=False)]
        header = [name for name, _ in truth.values()] + beside
        if len({name.lower() for name in header}) < len(header):
            continue
        guesses = guess_columns([str(name) for name in random.permutation(header)], frozenset(beside))
        found = {guess.signal: (guess.column, guess.unit) for guess in guesses.signals}
        assert {**found, "time": (guesses.time.column, guesses.time.unit)} == truth


def _swing():
    """(time [s], speed [rad/s], angle [rad]) of a motor that swings."""
    time = np.arange(4000) * 1e-3
    return time, 90.0 * np.cos(3.0 * time), 30.0 * np.sin(3.0 * time)


def test_units_that_no_header_tells_are_found_by_the_way_that_the_speed_makes():
    time, speed, angle = _swing()
    for names, told, expected in (
        (("t", "n [rpm]", "phi"), (time, speed * 30.0 / math.pi, np.degrees(angle)), ("s", "rpm", "deg")),
        (("t", "n", "phi [°]"), (time, speed * 30.0 / math.pi, np.degrees(angle)), ("s", "rpm", "deg")),
        (("t", "omega [rad/s]", "phi [rad]"), (time * 1e3, speed, angle), ("ms", "rad/s", "rad")),
        (("t", "omega", "phi"), (time, speed, angle), ("s", "rad/s", "rad")),
    ):
        numbers = dict(zip(names, told, strict=True))
        guesses = with_units(guess_columns(names, numbers=numbers), numbers, None)
        units = {guess.signal: guess.unit for guess in guesses.signals}
        assert (guesses.time.unit, units["speed"], units["motor_position"]) == expected


def _units(names, told):
    numbers = dict(zip(names, told, strict=True))
    guesses = with_units(*counted_on_turns(guess_columns(names, numbers=numbers), numbers), None)
    return {guess.signal: guess.unit for guess in guesses.signals}, assumed_units(guesses)


@pytest.mark.parametrize(
    "names",
    [
        ("time", "pos_estimate", "vel_estimate", "Iq_measured"),
        ("t", "axis0.encoder.pos_estimate", "axis0.encoder.vel_estimate", "axis0.motor.current_control.Iq_measured"),
        ("timestamp", "position", "velocity", "q_current"),
        ("time", "ODrive 2 Position", "ODrive 2 Velocity", "ODrive 2 Current"),
        ("time", "odrive0_pos", "odrive0_vel", "odrive0_iq"),
    ],
)
def test_a_drives_log_that_tells_turns_is_read_so_and_said(names):
    time, speed, angle = _swing()
    units, assumed = _units(names, (time, angle / (2.0 * math.pi), speed / (2.0 * math.pi), np.cos(time)))
    assert (units["motor_position"], units["speed"]) == ("rev", "rev/s")
    [sentence] = [text for text in assumed if "logs turns" in text]
    assert f"{names[1]} in rev" in sentence and "and run init again" in sentence and "\n" not in sentence
    # a unit in the name is what holds
    named = (names[0], f"{names[1]} [deg]", f"{names[2]} [deg/s]", names[3])
    units, _ = _units(named, (time, np.degrees(angle), np.degrees(speed), np.cos(time)))
    assert (units["motor_position"], units["speed"]) == ("deg", "deg/s")


@pytest.mark.parametrize("beside", ["fet_temp", "axis0_fet_temperature"])
def test_a_drive_is_known_by_the_columns_beside_its_motion(beside):
    """ODrive's CAN messages tell the FET's temperature and the bus's voltage, however the motion is named."""
    time, speed, angle = _swing()
    turns = (angle / (2.0 * math.pi), speed / (2.0 * math.pi), np.cos(time))
    motion = ("motor_pos", "motor_vel", "motor_qcurrent")
    steady = (np.linspace(31.0, 36.0, len(time)), np.linspace(32.0, 32.5, len(time)))
    units, _ = _units(("time", *motion, beside, "bus_voltage"), (time, *turns, *steady))
    assert (units["motor_position"], units["speed"]) == ("rev", "rev/s")


def test_a_name_that_says_the_drive_says_nothing_of_other_columns():
    time, speed, angle = _swing()
    names = ("time", "shaft angle", "ODrive speed", "ODrive current")
    units, _ = _units(names, (time, angle, speed / (2.0 * math.pi), np.cos(time)))
    assert (units["motor_position"], units["speed"]) == ("rad", "rev/s")


@pytest.mark.parametrize("drive", ["ODrive 2", "axis 2", "Achse 2", "moteus 2"])
def test_the_number_of_a_drive_is_no_side_of_it(drive):
    """A 2 stands for the output elsewhere, as in `position 2`."""
    names = ("position [rad]", "velocity [rad/s]", "current [A]")
    guesses = guess_columns(["time [s]", *(f"{drive} {name}" for name in names)])
    assert {guess.signal for guess in guesses.signals} == {"motor_position", "speed", "current"}
    assert not any(guess.of_output for guess in guesses.signals)


def test_an_old_odrives_counts_are_no_turns():
    time, speed, angle = _swing()
    counts = 8192.0 / (2.0 * math.pi)
    units, _ = _units(("time", "pos_estimate", "vel_estimate"), (time, counts * angle, counts * speed))
    assert "rev" not in units.values()


def test_where_nothing_tells_the_unit_of_an_angle_it_is_said_what_was_assumed():
    time, speed, angle = _swing()
    for turn, unit in ((1.0, "rad"), (180.0 / math.pi, "deg"), (1.0 / (2.0 * math.pi), "rad")):
        units, [sentence] = _units(("time", "position", "velocity"), (time, turn * angle, turn * speed))
        assert units == {"motor_position": unit, "speed": f"{unit}/s"}
        assert "other units of angle" in sentence and "as in 'position [" in sentence


@pytest.mark.parametrize(
    ("per_radian", "unit"), [(1.0 / (2.0 * math.pi), "rev"), (180.0 / math.pi, "deg"), (1.0, "rad")]
)
def test_an_encoders_steps_tell_the_unit_of_an_angle(per_radian, unit):
    time, speed, angle = _swing()
    step = 2.0 * math.pi / 4096.0
    read = np.rint(0.1 * angle / step) * step
    units, [sentence] = _units(("time", "position", "velocity"), (time, per_radian * read, 0.1 * per_radian * speed))
    assert units["motor_position"] == unit
    assert "4096 counts per turn" in sentence


@pytest.mark.parametrize(("turn", "unit"), [(1.0, "rev"), (360.0, "deg"), (2.0 * math.pi, "rad")])
def test_an_angle_that_begins_again_tells_its_unit(turn, unit):
    time, _, angle = _swing()
    units, [sentence] = _units(("time", "position"), (time, np.mod(angle / (2.0 * math.pi), 1.0) * turn))
    assert units["motor_position"] == unit and "it wraps after" in sentence


@pytest.mark.parametrize("counts", [4096.0, 10000.0, 16384.0, 20000.0, 2.0**20])
def test_the_counts_of_a_turn_are_found_by_the_speed(counts):
    time, speed, angle = _swing()
    numbers = {"t [s]": time, "enc [counts]": np.rint(angle * counts / (2.0 * math.pi)), "w [rad/s]": speed}
    guesses = with_units(guessed(numbers), numbers, None)
    assert guesses.by_signal["motor_position"].counts == counts
    assert usual_counts(1.001 * counts) == counts and usual_counts(7777.0) is None


def test_of_two_positions_without_a_shaft_the_one_that_goes_farther_is_the_motors():
    time, _, angle = _swing()
    numbers = {"t [s]": time, "theta_a [rad]": angle / 50.0, "theta_b [rad]": angle, "i [A]": time}
    found = taken(numbers)
    assert (found["motor_position"], found["output_position"]) == ("theta_b [rad]", "theta_a [rad]")


@pytest.mark.slow
@pytest.mark.parametrize("number", range(4, 9))
def test_what_a_strangers_servo_hides_is_named(number, tmp_path):
    answer = answered(stranger_cases(1, 18)[number], folder=tmp_path, call=twin)
    assert answer.right, answer.line()


@pytest.mark.slow
@pytest.mark.parametrize("number", range(7))
def test_a_wrong_unit_or_sign_is_told(number, tmp_path):
    answer = answered(mistaken_cases(1, 7)[number], folder=tmp_path, call=twin)
    assert answer.right, answer.line()


@pytest.mark.slow
def test_usual_sizes_are_not_asked_about(tmp_path):
    case = stranger_cases(1, 18)[7]
    files = case.write(tmp_path)
    told = done("init", files[0], "-o", tmp_path / "servo", *case.options)
    assert "warning" not in told.stderr
