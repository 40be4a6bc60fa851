"""Rows that hold nothing in any column are gaps: they are left out, and counted in one warning."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.commands.init import run as init
from tests.trace_text import read_text, write_map


def rows(*empty, cells="nan,nan,nan", count=40, end=""):
    return "".join((cells if k in empty else f"{k / 100:g},{k % 7},{k % 5}") + f"{end}\n" for k in range(count))


@pytest.mark.parametrize(
    ("cells", "end"), [("nan,nan,nan", ""), (",,", ""), ("NaN,,n/a", ""), (" , nan , ", ""), ("nan,nan,nan", ";")]
)
def test_they_are_left_out_and_counted(tmp_path, cells, end):
    table = read_text(tmp_path, "t,pos,cur\n" + rows(0, 7, 8, 39, cells=cells, end=end))
    assert len(table.columns[0]) == 36 and np.isfinite(table.columns).all()
    assert table.warnings == ("run.csv: 4 rows (the first in line 2) hold no number in any column: left out",)
    lines = (tmp_path / "run.csv").read_text().split("\n")
    assert all(float(lines[table.line(k) - 1].split(",")[0]) == time for k, time in enumerate(table.columns[0]))


def test_one_is_named(tmp_path):
    (told,) = read_text(tmp_path, "t,pos,cur\n" + rows(20)).warnings
    assert told == "run.csv: line 22 holds no number in any column: left out"


def test_in_later_blocks_too(tmp_path, monkeypatch):
    monkeypatch.setattr("ema_bench_replay.traces.text_blocks._BLOCK", 64)
    table = read_text(tmp_path, "t,pos,cur\n" + rows(3, 17, 30))
    assert table.left_out == (3, 17, 30) and len(table.warnings) == 1 and table.line(29) == 34


def test_a_row_that_holds_some_numbers_is_refused_where_it_stands(tmp_path):
    with pytest.raises(InputError, match="line 22: column 'pos': holds no value"):
        read_text(tmp_path, "t,pos,cur\n" + rows(3).replace("0.2,6,0", "0.2,nan,0"))


def test_the_clock_sees_a_gap_and_names_the_right_lines(tmp_path):
    own = write_map(tmp_path, {"motor_position": "{columns: [pos], unit: rad}"})
    (tmp_path / "run.csv").write_text("t,pos,cur\n" + rows(7, 8, 9).replace("0.2,", "0.19,", 1))
    said = " ".join(load(tmp_path / "run.csv", import_map=own).warnings)
    assert "3 rows (the first in line 9) hold no number in any column: left out" in said
    assert "1 row (the first in line 22) tells the time of the row before: left out" in said
    assert "in 2 gaps, the longest 40 ms" in said


def test_a_file_of_such_rows_alone_is_refused(tmp_path):
    with pytest.raises(InputError):
        read_text(tmp_path, "t,pos,cur\n" + rows(*range(40)))


def test_init_reads_such_a_file(tmp_path, capsys):
    """It refused all of it, since every column had cells without a number."""
    (tmp_path / "run.csv").write_text("time [s],position [rad],current [A]\n" + rows(0, 12, 30))
    init(str(tmp_path / "m"), [tmp_path / "run.csv"])
    printed = capsys.readouterr()
    said = " ".join((printed.out + printed.err).split())
    assert "position [rad] → motor_position" in said and "cells hold no number" not in said
    assert said.count("hold no number in any column") == 1
