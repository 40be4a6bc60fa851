"""A power analyser's columns are named by letters that also are symbols of motion: V, S and Q."""

import numpy as np
import pytest

from tests.taken_columns import taken

SHARE = np.linspace(0.0, 1.0, 40)
VOLTAGE, CURRENT = 220.0 - SHARE, 1.2 + 3.0 * SHARE
APPARENT = np.sqrt(3.0) * VOLTAGE * CURRENT
ACTIVE = APPARENT * (0.4 + 0.5 * SHARE)
REACTIVE = np.sqrt(APPARENT**2 - ACTIVE**2)
ANALYSER = {"V": VOLTAGE, "I": CURRENT, "P": ACTIVE, "S": APPARENT, "Q": REACTIVE, "PHI": 60.0 - 30.0 * SHARE}
SHAFT = {"speed": 3600.0 - 400.0 * SHARE, "torque": 0.2 + 3.0 * SHARE}


def named(pattern, letters="VIPSQ"):
    return {pattern.format(letter): np.round(ANALYSER[letter], 2) for letter in letters}


@pytest.mark.parametrize("pattern", ["{}_SIGMA", "{}1", "PA1_{}_2", "{}"])
@pytest.mark.parametrize("letters", ["VIPSQ", "VIPSQ PHI", "PSQ", "VIS", "VIPQ"])
def test_voltages_and_powers_are_no_motion(pattern, letters):
    columns = named(pattern, letters.replace(" PHI", "")) | (named(pattern, ["PHI"]) if "PHI" in letters else {})
    found = taken({**columns, **SHAFT})
    assert found["speed"] == "speed" and not {"motor_position", "output_position"} & found.keys()
    assert found.get("current") == (pattern.format("I") if "I" in letters else None)
    assert "speed" not in taken(columns)


def test_it_is_said(drafted):
    said = drafted({**named("{}_SIGMA"), **SHAFT}, operating_points=True).said
    assert "voltages and powers of a power analyser: V_SIGMA, P_SIGMA, S_SIGMA, Q_SIGMA (if one is a shaft's" in said
    assert "speed → speed" in said and said.count("V_SIGMA") == 1


def test_without_the_relation_of_powers_the_letters_stay_symbols():
    columns = {"time [s]": 1e-2 * np.arange(40), "v": np.cos(SHARE), "s": np.sin(5.0 * SHARE), "i": CURRENT**2}
    assert {"speed": "v", "motor_position": "s", "current": "i"}.items() <= taken(columns).items()


@pytest.mark.parametrize(("letter", "word"), [("V_SIGMA", "speed"), ("n_x", "Drehzahl"), ("v", "output velocity")])
def test_a_word_goes_before_a_letter(letter, word):
    assert taken({letter: VOLTAGE, word: SHAFT["speed"], "I": CURRENT})["speed"] == word


def test_a_position_in_a_word_goes_before_one_in_a_letter():
    columns = {"time [s]": 1e-2 * np.arange(40), "S_x": 900.0 * SHARE**2, "angle": SHARE**3, "I [A]": CURRENT}
    assert taken(columns)["motor_position"] == "angle"
