"""Rows that name each of their numbers are read as a table with these names."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.trace_table import all_columns, read_table


def read(tmp_path, text):
    (tmp_path / "run.txt").write_text(text)
    return read_table(tmp_path / "run.txt", needed=all_columns)


@pytest.mark.parametrize(
    "row",
    [
        "Time: {t} Position: {p} Current: {c}\n",
        "Time:{t},Position:{p},Current:{c}\n",
        "Time={t}\tPosition={p}\tCurrent={c}\r\n",
        "Time = {t}; Position = {p}; Current = {c};\n",
    ],
)
def test_their_names_become_the_header(tmp_path, row):
    """What a microcontroller prints was said to hold no numbers."""
    rows = [(5000 + 3 * k, -0.5 * k, 1e-3 * k) for k in range(40)]
    table = read(tmp_path, "".join(row.format(t=t, p=p, c=c) for t, p, c in rows))
    assert table.header == ["Time", "Position", "Current"]
    np.testing.assert_allclose(np.array(table.columns).T, rows)
    assert table.line(0) == 1


def test_what_is_printed_before_them_is_no_row(tmp_path):
    rows = "".join(f"t: {k} motor speed: {k % 5}\n" for k in range(20))
    table = read(tmp_path, f"Servo test, v1.2\nweight: 300\n\n{rows}")
    assert table.header == ["t", "motor speed"] and len(table.columns[0]) == 20 and table.line(0) == 4


def test_a_line_among_them_that_is_none_is_named(tmp_path):
    rows = "".join(f"t: {k} pos: {k % 7}\n" for k in range(20))
    with pytest.raises(InputError, match="line 21: has 1 cell where the header has 2"):
        read(tmp_path, f"{rows}DONE POSITIONING\n{rows}")


@pytest.mark.parametrize("text", ["t: 1\nt: 2\nt: 3\n", "t: 1 q: 2\nt: 1 p: 2\n", "12:30:01 pos: 2\n12:30:02 pos: 3\n"])
def test_a_single_number_or_other_names_are_no_such_rows(tmp_path, text):
    with pytest.raises(InputError):
        read(tmp_path, text)


def test_many_rows_are_read_in_blocks(tmp_path):
    rows = 200_000
    table = read(tmp_path, "".join(f"t: {k} position [rad]: {0.5 * k}\n" for k in range(rows)))
    assert table.header == ["t", "position [rad]"] and len(table.columns[1]) == rows
    assert table.columns[1][-1] == 0.5 * (rows - 1)
