"""What stands between a text's header and its rows is skipped."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from tests.trace_text import read_text

ROWS = "0,1;1,5;2,5\n0,2;1,6;2,5\n0,3;1,7;2,5\n"
BETWEEN = {
    "a blank line": "\n",
    "a comment": "# rows follow\n",
    "an odd line": "Run 3; of today\n",
    "units of some": "Unit: s; rad\n",
    "all of these": "\nRun 3; of today\n% more\n\n",
}


@pytest.mark.parametrize("kind", BETWEEN)
@pytest.mark.parametrize("above", ["", "Recorder 7\n", "# made today\n\n"])
def test_the_rows_begin_where_numbers_do(tmp_path, kind, above):
    """A header that was found above such a line ended in a refusal of that line."""
    table = read_text(tmp_path, f"{above}t;pos;cur\n{BETWEEN[kind]}{ROWS}")
    assert table.header == ["t", "pos", "cur"] and table.warnings == ()
    assert np.array_equal(table.columns[0], [0.1, 0.2, 0.3]) and np.array_equal(table.columns[1], [1.5, 1.6, 1.7])
    assert table.path.read_text().split("\n")[table.line(0) - 1] == "0,1;1,5;2,5"


@pytest.mark.parametrize("kind", ["a blank line", "a comment"])
def test_columns_between_blanks_too(tmp_path, kind):
    table = read_text(tmp_path, "t  pos  cur\n" + BETWEEN[kind] + "0.1  1.5  2.5\n0.2  1.6  2.5\n")
    assert table.header == ["t", "pos", "cur"] and np.array_equal(table.columns[0], [0.1, 0.2])


@pytest.mark.parametrize("torn", ["0,05\n", "0,05;\n", "\n0,05\n"])
def test_a_first_row_that_is_cut_is_not_skipped(tmp_path, torn):
    with pytest.raises(InputError, match=r"line \d: "):
        read_text(tmp_path, f"t;pos;cur\n{torn}{ROWS}")


NUMBERS = [[0.5, 12.0, -0.25], [1.5, 13.0, 2e-3], [2.5, 14.0, 1.0]]


def matrix(mark, end):
    return "".join(mark.join(f"{value:g}" for value in row) + end + "\n" for row in NUMBERS)


@pytest.mark.parametrize("mark", [",", ", ", "\t", " "])
@pytest.mark.parametrize("above", ["% time,pos,speed\n% [s],[rad],[rad/s]\n", "%time,pos,speed\n%s,rad,rad/s\n"])
@pytest.mark.parametrize("end", ["", ";", " ;"])
def test_two_comments_above_the_rows_are_names_and_units_and_a_semicolon_may_end_each_row(tmp_path, mark, above, end):
    """As MATLAB writes a matrix; the first row was taken for the names of the columns."""
    table = read_text(tmp_path, "% bench 3\n\n" + above.replace(",", mark.strip(" ") or "  ") + matrix(mark, end))
    assert table.header == ["time [s]", "pos [rad]", "speed [rad/s]"] and table.warnings == ()
    assert np.array_equal(np.stack(table.columns, axis=1), NUMBERS)


@pytest.mark.parametrize("above", ["", "2019-05-11 15:22:21\n"])
def test_a_row_of_units_of_which_one_is_spelt_oddly_is_not_taken_for_names(tmp_path, above):
    """A dynamometer's log wrote rad.s for rad/s, and its units were read as the names of its columns."""
    names, units = "Supply, Torque, Speed, Setpoint, Motor", "V, N.mm, rad.s, rad.s, A"
    table = read_text(tmp_path, f"{above}{names}\n{units}\n48.1, -15.2, -10.5, 10.5, -1.6\n48.0, 9, 8, 7, 6\n")
    assert table.header == ["Supply [V]", "Torque [N.mm]", "Speed [rad.s]", "Setpoint [rad.s]", "Motor [A]"]
    assert np.array_equal(table.columns[0], [48.1, 48.0])


def test_a_semicolon_ends_the_rows_of_later_blocks_too(tmp_path, monkeypatch):
    monkeypatch.setattr("ema_bench_replay.traces.text_blocks._BLOCK", 64)
    table = read_text(tmp_path, "time,pos,speed;\n" + matrix(",", ";") * 20)
    assert table.header == ["time", "pos", "speed"] and len(table.columns[0]) == 60


def test_a_decimal_comma_before_the_semicolon_is_no_separator(tmp_path):
    table = read_text(tmp_path, "pos;\n0,5;\n0,6;\n")
    assert table.header == ["pos"] and np.array_equal(table.columns[0], [0.5, 0.6])


@pytest.mark.parametrize("rows", ["1.5\n2.5\n", "1:2:3\n2:3:4\n", "1|2\n3|4\n"])
def test_numbers_in_the_first_line_are_no_names(tmp_path, rows):
    with pytest.raises(InputError, match="line 2: the first line is numbers: no names of columns; put one there"):
        read_text(tmp_path, f"% bench 3\n{rows}")


@pytest.mark.parametrize(("cells", "last"), [(";7;", "column"), (";7;8;", "2 columns"), (";7;8", "2 columns")])
def test_columns_without_a_name_are_told_from_a_row_that_is_too_long(tmp_path, cells, last):
    with pytest.raises(InputError, match=rf"line 2: the header names 3 columns, and each row .*; name the last {last}"):
        read_text(tmp_path, "# bench 3\nt;pos;cur\n" + ROWS.replace("\n", f"{cells}\n"))
    with pytest.raises(InputError, match="line 2: has 5 cells where the header has 3; remove or complete the row"):
        read_text(tmp_path, "t;pos;cur\n" + ROWS.replace("2,5\n", "2,5;7;8\n", 1))


@pytest.mark.parametrize("cell", ["NaN", "nan", "-nan(ind)", "inf", "-Inf", "", "N/A", "null"])
@pytest.mark.parametrize("units", ["", "s,rad,A\n"])
@pytest.mark.parametrize("count", [1, 3])
def test_first_rows_that_hold_only_a_time_are_rows(tmp_path, cell, units, count):
    """A logger that starts before its drive answers: the first such row was taken for the names of the columns."""
    before = "".join(f"{0.1 * k:.1f},{cell},{cell}\n" for k in range(count))
    text = f"time,position,current\n{units}{before}1.0,1.5,2.5\n2.0,1.6,2.5\n"
    table = read_text(tmp_path, text, needed=lambda header: ())
    assert [name.split(" ")[0] for name in table.header] == ["time", "position", "current"]
    assert len(table.columns[0]) == count + 2 and np.isnan(table.columns[1][:count]).all()
    assert table.columns[1][count:].tolist() == [1.5, 1.6]


@pytest.mark.parametrize("first", ["NaN,NaN,NaN", "NaN,1.0,2.0", "0.0,1.0,NaN"])
def test_a_row_whose_time_is_missing_names_no_columns_either(tmp_path, first):
    table = read_text(tmp_path, f"time,position,current\n{first}\n1.0,1.5,2.5\n2.0,1.6,2.5\n", needed=lambda header: ())
    assert table.header == ["time", "position", "current"] and len(table.columns[0]) == 3 - (first == "NaN,NaN,NaN")


@pytest.mark.parametrize("above", ["", "% bench 3\n"])
def test_without_names_such_rows_are_refused(tmp_path, above):
    with pytest.raises(InputError, match="3 cells, and no line above them names as many columns"):
        read_text(tmp_path, f"{above}0.0,NaN,NaN\n0.1,NaN,NaN\n0.2,1.5,2.5\n0.3,1.6,2.5\n")


def test_a_gap_that_outlasts_the_lines_searched_hides_no_header(tmp_path):
    gap = "".join(f"{k},NaN,NaN\n" for k in range(300))
    table = read_text(tmp_path, f"time,position,current\n{gap}300,1.5,2.5\n", needed=lambda header: ())
    assert table.header == ["time", "position", "current"] and len(table.columns[0]) == 301


@pytest.mark.parametrize("between", ["", "\n", "17,,\n"])
def test_numbers_that_a_table_program_filled_up_with_empty_cells_are_no_rows(tmp_path, between):
    table = read_text(tmp_path, f"2024,,\n{between}time,position,current\n1.0,1.5,2.5\n2.0,1.6,2.5\n")
    assert table.header == ["time", "position", "current"] and len(table.columns[0]) == 2


INFORMATION = """SERVO Graph,3,,,,,
ItemCount,3,,,,MIN,MAX
-1,321,MX-1(2.0),Realtime Tick,#000000,-10,8
-1,321,MX-1(2.0),Present Position,#ffff00,,
"""


@pytest.mark.parametrize("above", [INFORMATION, INFORMATION.replace(",,,,,", ""), "Gain,2,fast\n0.5,12,slow\n"])
@pytest.mark.parametrize("units", ["", "ms,,counts,,,,\n"])
def test_numbers_among_words_of_information_are_no_rows(tmp_path, above, units):
    """As servo programs list the curves of a graph: the names were looked for above that list."""
    text = f"{above}Time,Realtime Tick,Present Position,,,,\n{units}0,28228,-1,,,,\n106,28334,2,,,,\n"
    table = read_text(tmp_path, text, needed=lambda header: (0, 1, 2))
    assert [name.split(" [")[0] for name in table.header[:3]] == ["Time", "Realtime Tick", "Present Position"]
    assert [column.tolist() for column in table.columns[:3]] == [[0.0, 106.0], [28228.0, 28334.0], [-1.0, 2.0]]
    assert text.split("\n")[table.line(0) - 1].startswith("0,28228")


@pytest.mark.parametrize("first", ["0.1,2,running", "0.1,NaN,running", "0.1,2,3"])
def test_a_second_header_hides_no_rows(tmp_path, first):
    """A logger that was started anew: what is above its second header are rows, though they may hold words."""
    rows = f"{first}\n{first.replace('0.1', '0.2')}\ntime,position,state\n{first.replace('0.1', '0.3')}\n"
    with pytest.raises(InputError, match="line 4: column 'time': 'time' is no number"):
        read_text(tmp_path, f"time,position,state\n{rows}", needed=lambda header: (0,))
