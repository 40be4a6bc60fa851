"""Units in columns' names whose letters are neither Latin nor Greek: they need no mark before them."""

import pytest

from ema_bench_replay.traces.header_words import header_words, in_other_letters


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("電流A", "A"),
        ("电压V", "V"),
        ("轉速rpm", "rpm"),
        ("速度deg/s", "deg/s"),
        ("轉矩kgf.m", "kgf m"),
        ("轉矩n-m", "N m"),
        ("温度°C", "degC"),
        ("角度°", "deg"),
        ("回転数r/min", "rpm"),
        ("токA", "A"),
        ("轉差 s", "s"),
        ("電流(A)", "A"),
    ],
)
def test_a_unit_directly_behind_other_letters_is_read(name, unit):
    read = header_words(name)
    assert read.unit == unit and read.words == () and in_other_letters(name)


@pytest.mark.parametrize(
    ("name", "words"),
    [("電机speed", ("speed",)), ("效率eff", ("eff",)), ("位置motor_pos", ("motor", "pos")), ("轉差drpm", ("drpm",))],
)
def test_other_latin_letters_behind_them_are_words(name, words):
    read = header_words(name)
    assert read.words == words and read.unit is None and read.foreign == ""


@pytest.mark.parametrize(("name", "unit"), [("功率W", "W"), ("入力kW", "kW"), ("S功率VA", "VA"), ("Q功率VAR", "VAR")])
def test_a_unit_of_power_behind_them_is_of_no_signal(name, unit):
    assert header_words(name).foreign == unit


@pytest.mark.parametrize("name", ["θm", "τm", "ωm", "Größem", "naïveA", "µm", "φ°"])
def test_latin_and_greek_letters_end_no_word(name):
    assert not in_other_letters(name)
    assert header_words(name).unit in (None, "um")
