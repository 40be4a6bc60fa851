"""Columns that are no signal of the machine though they look like one: powers, and positions of another axis."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.new_machine import drafts
from ema_twin_sim.new_machine.columns import guess_columns
from ema_twin_sim.new_machine.given import Given
from ema_twin_sim.new_machine.model_draft import ModelDraft
from ema_twin_sim.new_machine.shaft import Shaft
from tests.taken_columns import guessed, taken

TIME = np.arange(1500) * 2e-3
ANGLE = 30.0 * (1.0 - np.cos(2.0 * TIME))
CURRENT = 0.5 * np.sign(np.sin(2.0 * TIME)) + 0.2 * np.cos(2.0 * TIME)


MOTOR = {"time [s]": TIME, "current [A]": CURRENT, "motor position [rad]": ANGLE}


@pytest.mark.parametrize(
    "name",
    [
        *("S_OutputPower", "X_OutputPower", "x power", "s Leistung", "output position [W]", "s [kW]", "x_kW"),
        *("s in kW", "q puissance"),
    ],
)
def test_a_power_is_no_position(name):
    """The letter of an axis, as X or S, is a symbol of a position elsewhere."""
    numbers = {"time [s]": TIME, "motor position [rad]": ANGLE, name: 1e-7 * ANGLE}
    assert name in guessed(numbers).left


@pytest.mark.parametrize("times", [1e-7, -1e-7])
def test_a_position_that_no_gear_makes_is_left_out_and_said(drafted, drawn, times):
    """A gear ratio beyond those of a model ended init."""
    draft = drafted({**MOTOR, "output position [rad]": times * ANGLE})
    assert "output position [rad]: not used as the output's position" in draft.said
    assert "the gear ratio would be 1e+07, as of no gear" in draft.said
    assert drawn().value("machine.gear_ratio") == 1.0
    assert "output_position" not in draft.map


def test_with_a_map_such_a_ratio_is_not_taken(tmp_path, drafted):
    (tmp_path / "m_map.yaml").write_text(
        "version: 1\ntime: {column: 'time \\[s\\]', unit: s}\nsignals:\n"
        "  current: {columns: ['current \\[A\\]'], unit: A}\n"
        "  output_position: {columns: ['output position \\[rad\\]'], unit: rad}\n"
        "  motor_position: {columns: ['motor position \\[rad\\]'], unit: rad}\n"
    )
    columns = {**MOTOR, "output position [rad]": 1e-7 * ANGLE}
    line = drafted(columns, import_map=str(tmp_path / "m_map.yaml")).line("gear_ratio")
    assert "value: 1," in line
    assert "CHECK: both positions give 1e+07" in line


def test_a_speed_far_beyond_its_position_is_no_gear(drafted, drawn):
    draft = drafted({**MOTOR, "speed [rad/s]": 1.3e6 * np.gradient(ANGLE, TIME)})
    assert drawn().value("machine.gear_ratio") == 1.0
    assert "Are the units of both right?" in draft.map


def test_a_model_that_cannot_be_read_is_refused_with_the_users_file(monkeypatch):
    """The message had the path of a file that was already deleted."""
    monkeypatch.setattr(drafts, "draft_model", lambda *_: ModelDraft("version: 1\nmachine: {gear_ratio: 4e6}\n"))
    with pytest.raises(InputError) as refusal:
        drafts.checked_model((), Given("q", None, None), Shaft(), "t.csv")
    assert str(refusal.value).startswith("t.csv: the model drafted from it: ")
    assert "model.yaml" not in str(refusal.value)


@pytest.mark.parametrize(
    "name", ["torque feedforward [Nm]", "torque ff [Nm]", "torqueFeedForward", "M Vorsteuerung [Nm]"]
)
def test_a_feedforward_is_neither_a_measurement_nor_a_command(name):
    numbers = {"time [s]": TIME, "position [rad]": ANGLE, name: 0.3 * CURRENT}
    assert [*taken(numbers)] == ["motor_position"]
    numbers["torque command [Nm]"] = CURRENT
    assert taken(numbers)["motor_torque"] == "torque command [Nm]"


def test_a_feedforward_command_is_none_either():
    numbers = {"time [s]": TIME, "position [rad]": ANGLE, "torque feedforward setpoint [Nm]": 0.3 * CURRENT}
    assert [*taken(numbers)] == ["motor_position"]


def test_where_every_column_has_a_hole_the_names_are_not_to_blame(drafted):
    """The refusal said that no column was recognised, and to rename them."""
    count = np.arange(40)
    holed = {
        name: np.where(count == 20, np.nan, count % of) for name, of in (("position [rad]", 7), ("current [A]", 5))
    }
    with pytest.raises(InputError, match=r"current \[A\], position \[rad\]: without these nothing is left to read"):
        drafted({"clock [ms]": 0.01 * count, **holed})


COUNT = np.arange(float(len(TIME)))


@pytest.mark.parametrize("name", ["n", "i", "v", "s", "current"])
@pytest.mark.parametrize("counted", [COUNT, 7.0 + 4.0 * COUNT, 0.1 * COUNT])
def test_a_column_that_numbers_the_rows_is_no_signal(name, counted):
    """`n` was taken for the speed, and the position was left out since it did not go with it."""
    columns = {"t": TIME, name: counted, "angle": ANGLE, "motor_current": CURRENT}
    guesses = guessed(columns)
    assert taken(columns) == {"motor_position": "angle", "current": "motor_current"}
    assert guesses.row_counters == (name,) and name in guesses.left


@pytest.mark.parametrize(
    ("name", "values", "signal"),
    [
        ("n", COUNT + 0.001 * np.sin(COUNT), "speed"),
        ("n [1/min]", COUNT, "speed"),
        ("angle", COUNT, "motor_position"),
        ("position setpoint", COUNT, "output_command"),
    ],
)
def test_what_may_rise_steadily_is_one_all_the_same(name, values, signal):
    columns = {"t": TIME, name: values, "motor_current": CURRENT}
    guesses = guessed(columns)
    assert guesses.row_counters == () and signal in {guess.signal for guess in guesses.signals}
    assert guess_columns(list(columns)).row_counters == ()


def test_speeds_set_one_after_another_are_those_of_operating_points():
    columns = {"n": 100.0 * np.arange(1.0, 41.0), "M": 0.1 + 1e-3 * np.arange(40.0)}
    assert guessed(columns).row_counters == ()


def test_init_says_which_column_numbers_the_rows(drafted):
    columns = {"t": TIME, "n": COUNT, "angle": ANGLE, "motor_current": CURRENT}
    told = drafted(columns).said
    assert "n: not used, since it rises by the same step in every row" in told
    assert "angle → motor_position" in told and "nothing in common" not in told


@pytest.mark.parametrize("names", [",angle,speed", ",foo,bar"])
def test_a_refusal_lists_no_empty_name(drafted, names):
    """As that of the index that pandas writes before the columns."""
    columns = dict(zip(names.split(","), (COUNT, ANGLE, np.sin(2.0 * TIME)), strict=True))
    with pytest.raises(InputError, match=f"among {names[1:].replace(',', ', ')}; "):
        drafted(columns)


def test_a_file_of_many_columns_is_refused_in_whole_sentences(drafted):
    time = np.arange(900) * 2e-3
    wheels = {f"{side} {what}": k * 3.0 + np.sin(3.0 * time) for k, side in enumerate(("left", "right"))
              for what in ("velocity", "current", "raw current", "filtered current", "velocity setpoint")}  # fmt: skip
    with pytest.raises(InputError) as refusal:
        drafted(wheels)
    text = str(refusal.value)
    assert "…" not in text and "more; the rows look like samples; export the time too" in text
    assert text.endswith("give --operating-points")
