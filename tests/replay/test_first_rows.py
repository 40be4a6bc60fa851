"""The first rows of a text, which a logger writes before its drive answers: a few are left out and said."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.trace_table import all_columns
from tests.trace_text import read_text

ROWS = "".join(f"{row * 0.01:.2f};{row * 0.1:.1f};{row % 7}\n" for row in range(30))


def read(tmp_path, begin, needed=all_columns, rows=ROWS):
    return read_text(tmp_path, f"t;pos;cur\n{begin}{rows}", needed=needed)


@pytest.mark.parametrize("needed", [all_columns, lambda header: (), lambda header: (0, 2)])
def test_one_is_named_with_its_column(tmp_path, needed):
    """Empty cells of the first row alone made every column one that is not used."""
    table = read(tmp_path, "-0.01;;\n", needed)
    (said,) = table.warnings
    assert said.startswith("run.csv: line 2: the first row is left out, since its column") and "is empty" in said
    assert len(table.columns[0]) == 30 and np.isfinite(table.columns[2]).all()
    assert table.line(0) == 3 and table.line(29) == 32


def test_a_few_are_counted_at_both_ends(tmp_path):
    table = read(tmp_path, "-0.02;;\n-0.01;0.0;NaN\n", rows=f"{ROWS}0.30;3.0;x\n")
    first, last = table.warnings
    assert first.startswith("run.csv: lines 2 to 3: the first 2 rows are left out, since they lack numbers that all")
    assert last.startswith("run.csv: line 34: the last row is left out")
    assert len(table.columns[0]) == 30 and np.isfinite(table.columns).all() and table.line(0) == 4


@pytest.mark.parametrize("begin", ["-0.01;x;\n" * 4, "-0.01;;\n" * 11, "-0.02;0.0;1\n-0.01;;\n"])
def test_many_or_one_behind_the_beginning_are_refused(tmp_path, begin):
    line = 2 if begin.startswith("-0.01") else 3
    with pytest.raises(InputError, match=f"line {line}: column 'pos'"):
        read(tmp_path, begin)


def test_the_first_wrong_cell_is_named_if_another_comes_later(tmp_path):
    with pytest.raises(InputError, match="line 2: column 'pos'"):
        read(tmp_path, "-0.01;;\n", rows=f"{ROWS}0.30;;1\n{ROWS}")


def test_a_column_that_is_not_needed_begins_nothing(tmp_path):
    table = read(tmp_path, "-0.01;0.0;\n", lambda header: (0, 1))
    assert len(table.columns[0]) == 31 and table.warnings == ()


@pytest.mark.parametrize("needed", [all_columns, lambda header: ()])
def test_a_signal_that_begins_later_than_the_clock_begins_the_recording(tmp_path, needed):
    table = read(tmp_path, "-0.01;0.0;NaN\n" * 9, needed)
    (said,) = table.warnings
    assert said.startswith("run.csv: lines 2 to 10: the first 9 rows are left out, since they lack numbers that all")
    assert len(table.columns[0]) == 30 and np.isfinite(table.columns).all() and table.line(0) == 11
