"""The last rows of a text, which a logger writes while it is switched off: a few are left out and said."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.trace_table import all_columns
from tests.trace_text import read_text

ROWS = "".join(f"{row * 0.01:.2f};{row * 0.1:.1f};{row % 7}\n" for row in range(30))


def read(tmp_path, end, header="t;pos;cur", needed=all_columns, rows=ROWS):
    return read_text(tmp_path, f"{header}\n{rows}{end}", needed=needed)


def test_one_is_named_with_its_column(tmp_path):
    table = read(tmp_path, "0.30;3.0;NaN\n")
    said = "run.csv: line 32: the last row is left out, since its column 'cur' holds 'NaN', which is no number"
    assert table.warnings == (said,) and len(table.columns[0]) == 30


def test_those_that_a_block_begins_with_are_the_last_too(tmp_path, monkeypatch):
    """They were told as the first rows of the text."""
    monkeypatch.setattr("ema_bench_replay.traces.text_blocks._BLOCK", len(f"t;pos;cur\n{ROWS}"))
    (said,) = read(tmp_path, "0.30;3.0;NaN\n").warnings
    assert said.startswith("run.csv: line 32: the last row is left out")


@pytest.mark.parametrize("end", ["0.30;3.0;NaN\n", "0.30;3.0;\n", "-1.#IO;x;y\n"])
@pytest.mark.parametrize("count", [2, 3])
def test_a_few_are_counted(tmp_path, end, count):
    table = read(tmp_path, end * count)
    (said,) = table.warnings
    assert said.startswith(f"run.csv: lines 32 to {31 + count}: the last {count} rows are left out")
    assert len(table.columns[0]) == 30 and np.isfinite(table.columns).all()


@pytest.mark.parametrize("end", ["0.30;3.0;NaN\n;;\n", ";;\n0.30;;3\n", ";;\n;;\n0.3", ";;\n" * 9])
def test_they_need_not_be_alike(tmp_path, end):
    assert len(read(tmp_path, end).columns[0]) == 30


@pytest.mark.parametrize("end", ["0.30;3.0;x\n" * 4, "0.30;3.0;NaN\n" * 11, "0.30;3.0;NaN\n0.31;3.1;1\n"])
def test_many_or_one_before_the_end_are_refused(tmp_path, end):
    with pytest.raises(InputError, match="line 32: column"):
        read(tmp_path, end)


def test_rows_in_another_format_are_refused(tmp_path):
    with pytest.raises(InputError, match="line 32: column 'pos'"):
        read(tmp_path, "0.30;3.000.000,1;1\n")


def test_a_file_of_such_rows_alone_is_refused(tmp_path):
    with pytest.raises(InputError):
        read(tmp_path, ";;\n;;\n", rows="")


@pytest.mark.parametrize("before", ["0", "running"])
def test_a_column_that_is_not_needed_ends_nothing(tmp_path, before):
    rows = "".join(f"{line};{before}\n" for line in ROWS.splitlines())
    table = read(tmp_path, "0.30;3.0;1;stopped\n", "t;pos;cur;state", lambda header: (0, 1, 2), rows)
    assert len(table.columns[0]) == 31 and table.warnings == ()
    table = read(tmp_path, "0.30;3.0;x;stopped\n", "t;pos;cur;state", lambda header: (0, 1, 2), rows)
    assert len(table.columns[0]) == 30 and "column 'cur' holds 'x'" in table.warnings[0]


def test_if_no_column_is_needed_each_that_holds_numbers_counts(tmp_path):
    table = read(tmp_path, "0.30;3.0;NaN\n0.31;3.0;NaN\n", needed=lambda header: ())
    assert len(table.columns[0]) == 30 and "the last 2 rows" in table.warnings[0]
    table = read(tmp_path, "0.30;3.0;NaN\n" * 11, needed=lambda header: ())
    assert len(table.columns[0]) == 41 and np.isnan(table.columns[2]).sum() == 11


@pytest.mark.parametrize("needed", [all_columns, lambda header: (), lambda header: (0, 2)])
def test_a_signal_shorter_than_the_clock_ends_the_recording(tmp_path, needed):
    """Programs that write signals of their own lengths beside each other leave the shorter ones' cells empty."""
    table = read(tmp_path, "0.30;3.0;\n" * 9, needed=needed)
    said = "run.csv: lines 32 to 40: the last 9 rows are left out, since they lack numbers that all rows before hold"
    assert table.warnings == (f"{said}; in the first of them, column 'cur' is empty",)
    assert len(table.columns[0]) == 30 and np.isfinite(table.columns).all()


def test_the_shortest_signal_that_is_needed_ends_the_recording(tmp_path):
    end = "0.30;3.0;\n" * 5 + "0.40;;\n" * 4
    assert len(read(tmp_path, end).columns[0]) == 30
    assert len(read(tmp_path, end, needed=lambda header: (0, 1)).columns[0]) == 35


def test_rows_that_alone_hold_numbers_of_a_column_stay_if_none_is_needed(tmp_path):
    """The last of several stacked logs, each with columns of its own, is no end of the first."""
    rows = "".join(f"{line};\n" for line in ROWS.splitlines())
    table = read(tmp_path, "0.30;;;7\n" * 9, "t;pos;cur;heat", lambda header: (), rows)
    assert len(table.columns[0]) == 39


def noted(tmp_path, note, *, needed=all_columns, rows=ROWS, end="0.30;3.0;1;\n"):
    """A table whose header ends in an empty name, below which its row number k holds ``note(k)``."""
    lines = "".join(f"{line};{note(k)}\n" for k, line in enumerate(rows.splitlines()))
    return read(tmp_path, end, "t;pos;cur;", needed, lines)


@pytest.mark.parametrize("needed", [all_columns, lambda header: (), lambda header: (0, 2)])
@pytest.mark.parametrize("note", ["stiff", "7"])
@pytest.mark.parametrize("at", [(0,), (4, 5, 20), range(14), (29,)])
def test_notes_beside_a_table_are_not_read(tmp_path, needed, note, at):
    """A spreadsheet's remark right of the table, below an empty name, was a cell too many."""
    table = noted(tmp_path, lambda k: note if k in at else "", needed=needed)
    assert table.header == ["t", "pos", "cur"] and len(table.columns[0]) == 31
    assert table.columns[0][4] == 0.04 and table.columns[2][4] == 4.0


@pytest.mark.parametrize("needed", [all_columns, lambda header: (), lambda header: (0, 2)])
@pytest.mark.parametrize("end", ["0.30;3.0;1;9\n", ""])
def test_a_column_without_a_name_that_most_rows_fill_is_refused(tmp_path, needed, end):
    """All numbers may stand a column too far to the right: the number of the row was read as the time."""
    with pytest.raises(InputError, match="line 1: the header names 3 columns, and each row has 4 cells"):
        noted(tmp_path, str, needed=needed, end=end)
    with pytest.raises(InputError, match="line 2: has 4 cells where the header has 3"):
        noted(tmp_path, lambda k: k if k % 3 else "x" * (k < 20), needed=needed)


def test_notes_far_below_are_not_read_either(tmp_path):
    rows = "".join(f"{row * 0.01:.2f};{row * 0.1:.1f};{row % 7}\n" for row in range(300_000))
    table = noted(tmp_path, lambda k: "stiff" if k == 299_990 else "", rows=rows, end="")
    assert len(table.columns[0]) == 300_000 and table.columns[2][299_990] == 299_990 % 7


@pytest.mark.parametrize("rows", [5, 9])
def test_both_ends_together_are_a_quarter_at_most(tmp_path, rows):
    late, early = "-0.01;;1\n" * rows, "0.30;3.0;\n" * rows
    if rows == 5:
        table = read(tmp_path, early, rows=late + ROWS)
        assert len(table.columns[0]) == 30 and len(table.warnings) == 2 and table.is_cut
    else:
        with pytest.raises(InputError, match="line 2: column 'pos': the cell is empty"):
            read(tmp_path, early, rows=late + ROWS)
