"""The first hour of a stranger: a CSV in their own words and units, `init`, `discover`, and nothing edited."""

import math

import numpy as np
import pytest

from ema_twin_sim.new_machine.columns import guess_columns
from ema_twin_sim.new_machine.units_by_numbers import usual_counts, with_units
from tests.accuracy.strangers.cases import mistaken_cases, stranger_cases
from tests.accuracy.strangers.judge import answered
from tests.accuracy.strangers.words import BESIDE, QUANTITY, UNITS, named, spelt, with_unit
from tests.command_line import done

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


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        (["t", "φ̇", "φ", "i_q", "i_d"], {"motor_position": "φ", "speed": "φ̇", "current": "i_q"}),
        (["t", "q_l", "q_m", "tau"], {"motor_position": "q_m", "output_position": "q_l", "motor_torque": "tau"}),
        (["t", "x [mm]", "F [N]", "v [mm/s]"],
         {"motor_position": "x [mm]", "motor_torque": "F [N]", "speed": "v [mm/s]"}),
        (["t", "angle [deg]", "acceleration [rad/s²]", "I [A]"], {"motor_position": "angle [deg]", "current": "I [A]"}),
        (["t", "n*", "n", "Strom", "Fehler"], {"speed_setpoint": "n*", "speed": "n", "current": "Strom"}),
    ],
)  # fmt: skip
def test_symbols_are_told_apart(columns, expected):
    assert {guess.signal: guess.column for guess in guess_columns(columns).signals} == expected


def _swing(count=4000, period=1e-3):
    """(time [s], speed [rad/s], angle [rad]) of a motor that swings."""
    time = np.arange(count) * period
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


@pytest.mark.parametrize("counts", [4096.0, 10000.0, 16384.0, 20000.0, 2.0**20])
def test_the_counts_of_a_turn_are_found_by_the_speed(counts):
    time, speed, angle = _swing()
    numbers = {"t [s]": time, "enc [counts]": np.rint(angle * counts / (2.0 * math.pi)), "w [rad/s]": speed}
    guesses = with_units(guess_columns(list(numbers), numbers=numbers), numbers, None)
    assert {guess.signal: guess.counts for guess in guesses.signals}["motor_position"] == counts
    assert usual_counts(1.001 * counts) == counts and usual_counts(7777.0) is None


def test_of_two_positions_without_a_shaft_the_one_that_goes_farther_is_the_motors():
    time, _, angle = _swing()
    numbers = {"t [s]": time, "theta_a [rad]": angle / 50.0, "theta_b [rad]": angle, "i [A]": time}
    found = {guess.signal: guess.column for guess in guess_columns(list(numbers), numbers=numbers).signals}
    assert (found["motor_position"], found["output_position"]) == ("theta_b [rad]", "theta_a [rad]")


@pytest.mark.parametrize("number", range(4, 9))
def test_what_a_strangers_servo_hides_is_named(number, tmp_path):
    answer = answered(stranger_cases(1, 18)[number], folder=tmp_path)
    assert answer.right, answer.line()


@pytest.mark.parametrize("number", range(7))
def test_a_wrong_unit_or_sign_is_told(number, tmp_path):
    answer = answered(mistaken_cases(1, 7)[number], folder=tmp_path)
    assert answer.right, answer.line()


def test_usual_sizes_are_not_asked_about(tmp_path):
    case = stranger_cases(1, 18)[7]
    files = case.write(tmp_path)
    told = done("init", files[0], "-o", tmp_path / "servo", *case.options)
    assert "warning" not in told.stderr
