"""Units in columns' names whose letters are neither Latin nor Greek: they need no mark before them."""

import pytest

from ema_bench_replay.traces.header_words import COUNTS, header_words, in_other_letters


def each(names_by_what_they_tell):
    """Each name with what it tells."""
    return [(name, told) for told, names in names_by_what_they_tell.items() for name in names]


BEHIND = {
    "A": ("電流A", "токA", "電流(A)"),
    "V": ("电压V",),
    "rpm": ("轉速rpm", "回転数r/min"),
    "deg/s": ("速度deg/s",),
    "kgf m": ("轉矩kgf.m",),
    "N m": ("轉矩n-m",),
    "degC": ("温度°C",),
    "deg": ("角度°",),
    "s": ("轉差 s",),
}


@pytest.mark.parametrize(("name", "unit"), each(BEHIND))
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


SYMBOLS = {
    ("speed", "n"): ("转速n", "轉速N", "скоростьn"),
    ("speed", "v"): ("速度V",),
    ("torque", "m"): ("力矩M", "转矩M", "моментM"),
    ("voltage", "u"): ("电压U", "напряжениеU"),
    ("position", "q"): ("关节角度q",),
    ("time", "t"): ("时间t",),
    (): ("电机A", "轴a", "电机M", "质量m"),
}


@pytest.mark.parametrize(("name", "words"), each(SYMBOLS))
def test_a_letter_that_is_no_unit_of_what_the_name_says_is_a_symbol(name, words):
    """Speed n was read as a torque in N, torque M as a position in m, motor A as a current."""
    read = header_words(name)
    assert read.unit is None and read.words == words and read.foreign == ""


LETTERS = {
    "A": ("电机电流A", "力矩电流A", "전류A"),
    "s": ("时间s",),
    "m": ("位移m",),
    "N": ("推力N",),
    "degC": ("温度C",),
}


@pytest.mark.parametrize(("name", "unit"), each(LETTERS))
def test_a_letter_that_is_a_unit_of_what_the_name_says_is_one(name, unit):
    assert header_words(name).unit == unit


@pytest.mark.parametrize("name", ["速度 n", "转矩 M", "момент M"])
def test_a_letter_behind_a_blank_is_no_unit_of_what_the_name_does_not_say(name):
    assert header_words(name).unit is None and header_words(name).words == (name[-1].lower(),)


@pytest.mark.parametrize(
    ("name", "words", "foreign"),
    [
        ("knee[ActPack]:motor_current", ("knee", "act", "pack", "motor", "current"), ""),
        ("leg[FL].torque", ("leg", "fl", "torque"), ""),
        ("q[0].pos", ("q", "0", "pos"), ""),
        ("motor current [ActPack]", ("motor", "current"), "ActPack"),  # nothing follows: a unit, though an unknown one
        ("torque (%) filtered", ("torque", "filtered"), "%"),
        ("P (kW) mech", ("p", "mech"), "kW"),
        ("pos (3)", ("pos",), "3"),
    ],
)
def test_a_bracket_before_more_of_the_name_is_part_of_it(name, words, foreign):
    read = header_words(name)
    assert (read.words, read.foreign, read.unit) == (words, foreign, None)


def test_a_known_unit_may_stand_before_more_of_the_name():
    assert header_words("Torque (Nm) raw").unit == "N m"


@pytest.mark.parametrize(
    ("name", "words", "unit"),
    [
        ("Speed (actual)", ("speed", "actual"), None),
        ("speed (rpm) (act.)", ("speed",), "rpm"),
        ("Torque (motor, set) [Nm]", ("torque", "motor", "set"), "N m"),
    ],
)
def test_words_in_brackets_that_tell_which_value_it_is_are_no_unit(name, words, unit):
    read = header_words(name)
    assert read.words[: len(words)] == words and read.unit == unit and read.foreign == ""
    assert header_words("torque (pu)").foreign == "pu"


@pytest.mark.parametrize(
    ("name", "unit", "words"),
    [
        ("rpm_sp", "rpm", ("sp",)),
        ("rpm_out", "rpm", ("out",)),
        ("speed_rpm_cmd", "rpm", ("speed", "cmd")),
        ("wheel rpm 1", "rpm", ("wheel", "1")),
        ("rpm_left", "rpm", ("rpm", "left")),
        ("setrpm", "rpm", ("setrpm",)),
        ("torque_Nm_filtered", "N m", ("torque", "filtered")),
        ("torque_Nm_2", "N m", ("torque", "2")),
        ("pos_rad_des", "rad", ("pos", "des")),
        ("vel_rad_s_ref", "rad/s", ("vel", "ref")),
        ("current_mA_meas", "mA", ("current", "meas")),
        ("encoder_counts_raw", COUNTS, ("encoder", "raw")),
    ],
)
def test_a_unit_before_the_kind_of_value_is_read(name, unit, words):
    """A setpoint rpm_sp beside a speed rpm was read in rad/s."""
    read = header_words(name)
    assert read.unit == unit and read.words == words and not read.in_doubt and read.foreign == ""


@pytest.mark.parametrize(
    "name",
    [
        *("acc_m_s_2", "alpha_rad_s_2", "inertia_kg_m_2", "area_mm_2"),  # powers
        *("rpm_ratio", "rpm_dot", "delta_rpm_s_2", "rpm_rate_limited", "d_rpm_dt"),  # rates and ratios
        *("turn_ref", "count_raw", "current_A_cmd", "temp_c_filt", "erpm"),  # words, letters, electrical turns
    ],
)
def test_what_only_looks_like_a_unit_before_the_kind_of_value_is_none(name):
    assert header_words(name).unit is None
