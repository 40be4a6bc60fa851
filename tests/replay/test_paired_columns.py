"""Signals that are pairs of columns, of their time and their values, with their names in the line above."""

import pytest

from tests.one_line import refused_in_one_line
from tests.trace_text import read_text

ROWS = "0,10,0,-1.5,0,0.25\n2,11,2,-1.0,2,0.5\n4,12,4,-0.5,4,0.75\n"
ABOVE = "Position [inc],,Velocity [rpm],,Current [mA],\n"
NAMES = ["Position [inc]", "Velocity [rpm]", "Current [mA]"]


@pytest.mark.parametrize(
    "above", [ABOVE, ",,".join(["", *NAMES])[1:] + "\n", ",".join(f"{name},{name}" for name in NAMES) + "\n"]
)
@pytest.mark.parametrize(
    ("pair", "time"),
    [("X,Y", "time"), ("x,y", "time"), ("t,y", "t"), ("Time [s],Value", "Time [s]"), ("X (ms),Y", "time (ms)")],
)
def test_each_pair_is_its_name_and_all_have_one_time(tmp_path, above, pair, time):
    """As maxon's EPOS Studio writes; the X became both positions."""
    found = read_text(tmp_path, f"{above}{','.join([pair] * 3)}\n{ROWS}")
    assert found.header == [time, *NAMES]
    columns = [[0, 2, 4], [10, 11, 12], [-1.5, -1, -0.5], [0.25, 0.5, 0.75]]
    assert [column.tolist() for column in found.columns] == columns
    assert found.line(0) == 3


def test_units_beside_the_letters_and_below_them_belong_to_the_names(tmp_path):
    header = [f"{name} [{unit}]" for name, unit in (("time", "ms"), ("Position", "rad"), ("Current", "A"))]
    rows = "0;1;0;2\n2;3;2;4\n"
    for letters in ("X [ms];Y [rad];X;Y [A]\n", "X;Y;X;Y\nms;rad;ms;A\n"):
        assert read_text(tmp_path, f"Position;;Current;\n{letters}{rows}").header == header


@pytest.mark.parametrize("other", ["9,-0.5", ",", "8.0001,-0.5"])
def test_a_signal_with_a_time_of_its_own_is_refused(tmp_path, other):
    rows = [f"{2 * row},{row},{2 * row},{row}\n" for row in range(12)]
    rows[4] = f"8,4,{other}\n"
    with refused_in_one_line(tmp_path / "run.csv", "line 7", "time of its own", "'Velocity'", "one column of time"):
        read_text(tmp_path, "Position,,Velocity,\nX,Y,X,Y\n" + "".join(rows), needed=lambda header: ())


def test_letters_without_names_above_them_stay(tmp_path):
    for above in ("", "Recorder of 17.04.\n", "Position,Velocity,Current\n"):
        assert read_text(tmp_path, f"{above}X,Y,X,Y,X,Y\n{ROWS}").header == ["X", "Y"] * 3
