"""Rows that name each of their numbers are read as a table with these names."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.named_numbers import named_numbers
from tests.trace_text import read_text


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
    table = read_text(tmp_path, "".join(row.format(t=t, p=p, c=c) for t, p, c in rows))
    assert table.header == ["Time", "Position", "Current"]
    np.testing.assert_allclose(np.array(table.columns).T, rows)
    assert table.line(0) == 1


def test_what_is_printed_before_them_is_no_row(tmp_path):
    rows = "".join(f"t: {k} motor speed: {k % 5}\n" for k in range(20))
    table = read_text(tmp_path, f"Servo test, v1.2\nweight: 300\n\n{rows}")
    assert table.header == ["t", "motor speed"] and len(table.columns[0]) == 20 and table.line(0) == 4


def test_a_line_among_them_that_is_none_is_named(tmp_path):
    rows = "".join(f"t: {k} pos: {k % 7}\n" for k in range(20))
    with pytest.raises(
        InputError, match="line 21: does not name t, pos, in this order and each with a number; correct"
    ):
        read_text(tmp_path, f"{rows}DONE POSITIONING\n{rows}")


@pytest.mark.parametrize("text", ["t: 1\nt: 2\nt: 3\n", "t: 1 q: 2\nt: 1 p: 2\n", "12:30:01 pos: 2\n12:30:02 pos: 3\n"])
def test_a_single_number_or_other_names_are_no_such_rows(tmp_path, text):
    with pytest.raises(InputError):
        read_text(tmp_path, text)


def test_many_rows_are_read_in_blocks(tmp_path):
    rows = 200_000
    table = read_text(tmp_path, "".join(f"t: {k} position [rad]: {0.5 * k}\n" for k in range(rows)))
    assert table.header == ["t", "position [rad]"] and len(table.columns[1]) == rows
    assert table.columns[1][-1] == 0.5 * (rows - 1)


@pytest.mark.parametrize("apart", [" ", ",", "\t"])
@pytest.mark.parametrize("row", ["t: 3{0}cur: 5", "pos: 4{0}t: 3{0}cur: 5", "t: 3{0}pos: x{0}cur: 5"])
def test_a_row_that_names_others_is_told_as_such(tmp_path, apart, row):
    rows = "".join(
        f"t: {k} pos: {k % 7} cur: {k % 5}\n".replace(" ", apart).replace(f":{apart}", ": ") for k in range(9)
    )
    with pytest.raises(InputError, match="line 10: does not name t, pos, cur, in this order"):
        read_text(tmp_path, f"{rows}{row.format(apart)}\n{rows}")


@pytest.mark.parametrize("missing", ["inf", "-inf", "nan"])
def test_a_number_that_is_none_is_told_with_its_column(tmp_path, missing):
    rows = "".join(f"t: {k} pos: {k % 7}\n" for k in range(9))
    with pytest.raises(InputError, match="line 10: column 'pos'"):
        read_text(tmp_path, f"{rows}t: 9 pos: {missing}\n{rows}")


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_blank_lines_between_them_are_no_rows(tmp_path, end):
    table = read_text(tmp_path, "".join(f"t: {k} pos: {0.5 * k}{end}{end}" for k in range(50)))
    np.testing.assert_array_equal(table.columns[1], 0.5 * np.arange(50))
    assert table.line(3) == 7


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_the_maps_delimiter_does_not_matter(tmp_path, delimiter):
    table = read_text(tmp_path, "".join(f"t:{k},pos:{k % 7}\n" for k in range(50)), delimiter=delimiter)
    assert table.header == ["t", "pos"] and len(table.columns[0]) == 50


@pytest.mark.parametrize("long", ["Measured{}here", "t:{}x", "a{0}b{0}c", "{}=", "t: 1 {}"])
@pytest.mark.parametrize("fill", [" ", "a", "1", "a ", "\t", " \t", "=", ";", ".1"])
def test_a_long_line_is_no_such_row(long, fill):
    """It is read as fast as any other: this would not end if the time rose with the square of its length."""
    line = long.format(fill * (200_000 // len(fill))).encode()
    assert named_numbers(b"\n".join([line] * 3)) is None
