"""Columns with one name: none is taken twice, and `init` does not choose between those that differ."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.columns import guess_columns
from tests.one_line import refused_in_one_line

TIME = np.arange(600) * 2e-3
ANGLE = 40.0 / 6.0 * (1.0 - np.cos(6.0 * TIME))
CURRENT = 0.3 * np.sin(6.0 * TIME) + 0.24 * np.cos(6.0 * TIME)


def csv(place, header, *columns):
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    place.write_text("\n".join([header, *rows, ""]))
    return place


def test_a_name_is_of_one_signal():
    numbers = {"X": TIME, "Y": ANGLE}
    taken = [guess.column for guess in guess_columns(["X", "Y", "X", "Y"], numbers=numbers).signals]
    assert len({*taken}) == len(taken)


def test_of_two_columns_with_one_name_none_is_chosen(drafted, tmp_path):
    header = "time [s],angle [rad],angle [rad],current [A]"
    trace = csv(tmp_path / "run.csv", header, TIME, ANGLE, 0.02 * ANGLE, CURRENT)
    with refused_in_one_line(trace, "line 1", "columns 2 and 3", "'angle [rad]'", "a name of its own"):
        drafted(trace)


@pytest.mark.parametrize(
    "header", ["time [s],angle [rad],time [s],current [A]", "time [s],angle [rad],mark,current [A],mark"]
)
def test_columns_that_are_alike_or_not_used_may_have_one_name(drafted, tmp_path, header):
    columns = (TIME, ANGLE, TIME, CURRENT, ANGLE)[: header.count(",") + 1]
    draft = drafted(csv(tmp_path / "run.csv", header, *columns))
    assert "angle [rad] → motor_position" in draft.said and "ema-twin discover" in draft.said


def test_a_torque_beside_the_time_that_has_the_same_letter_is_read(tmp_path):
    """T was read as t, which stands before it."""
    from ema_bench_replay.load import load

    header = "t,speed [rad/s],angle [rad],T"
    torque = 7.0 + CURRENT
    trace = csv(tmp_path / "run.csv", header, TIME, 40.0 * np.sin(6.0 * TIME), ANGLE, torque)
    (tmp_path / "map.yaml").write_text(
        "version: 1\ntime: {column: t, unit: s}\nsignals: {motor_position: {columns: ['angle .rad.']}, "
        "motor_torque: {columns: [T]}}\n"
    )
    assert load(trace, import_map=tmp_path / "map.yaml").signals["motor_torque"] == pytest.approx(torque)


def test_operating_points_of_two_encoders_alone_are_not_searched(drafted):
    """The search, which was proposed, refuses them."""
    angle = np.random.default_rng(3).uniform(0.0, 300.0, 60)
    said = drafted({"motor position [rad]": angle, "output position [rad]": angle / 50.0}).said
    assert "each row is read as an operating point" in said
    assert "ema-twin discover" not in said and "only backlash" not in said
    assert "No current or torque was found" in said and "a column of the time is enough" in said
