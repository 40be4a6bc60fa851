"""Rows end in a line feed, a carriage return or both; a line break inside a quoted cell ends none."""

import pytest

from ema_bench_replay.load import load
from ema_bench_replay.traces import text_blocks
from ema_bench_replay.traces.trace_writer import write_trace
from tests.trace_text import HEADER, ROWS, SIEMENS, read_text

_ROWS = [f"{row}.0,{row}.5,{row}.25" for row in range(300)]


@pytest.mark.parametrize("end", ["", "\r", "\n"])
def test_a_carriage_return_without_a_line_feed_ends_a_row(tmp_path, end):
    """As Excel for Mac writes; the last row may lack it."""
    table = read_text(tmp_path, "\r".join(["time [s],motor position [rad],current [A]", *_ROWS]) + end)
    assert len(table.header) == 3 and table.columns[0].tolist() == list(range(300))
    assert table.warnings == ()


def test_a_carriage_return_between_two_blocks_and_its_line_feed_end_one_row(tmp_path, monkeypatch):
    text = "time [s],current [A]\r" + "".join(f"{row},{row}.5\r\n" for row in range(40))
    for size in range(24, 40):
        monkeypatch.setattr(text_blocks, "_BLOCK", size)
        table = read_text(tmp_path, text)
        assert len(table.columns[0]) == 40 and table.warnings == ()


def test_a_trace_of_carriage_returns_is_written_with_them_again(tmp_path):
    text = "\r".join([HEADER, *ROWS, ""]).encode()
    (tmp_path / "trace.csv").write_bytes(text)
    write_trace(load(tmp_path / "trace.csv"), tmp_path / "again.csv", SIEMENS)
    assert (tmp_path / "again.csv").read_bytes() == text


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("size", [1 << 22, 64, 65, 66, 67, 68, 69, 70, 71])
def test_a_line_break_in_a_quoted_cell_ends_no_row(tmp_path, delimiter, size, monkeypatch):
    """As a multimeter's reply that was not stripped; wherever the blocks of the file end."""
    monkeypatch.setattr(text_blocks, "_BLOCK", size)
    cells = [[f"{row}.0", f'"said ""{row}""\n\nOK\n"', f'"{row}.25\n"'] for row in range(20)]
    lines = [["time [s]", "reply", "current [A]"], *cells]
    text = "".join(f"{delimiter.join(line)}\n" for line in lines).replace("\n", "\r\n")
    table = read_text(tmp_path, text, delimiter=delimiter, number_format="english", needed=lambda header: (0, 2))
    assert table.header == ["time [s]", "reply", "current [A]"]
    assert table.columns[0].tolist() == list(range(20))
    assert table.columns[2].tolist() == [row + 0.25 for row in range(20)]


def test_a_quotation_mark_that_begins_no_cell_joins_no_rows(tmp_path):
    """Inches are written so."""
    table = read_text(tmp_path, '# screw of 5"\ntime [s],stroke ["],current [A]\n0,1,2\n1,2,3\n2,3,4\n')
    assert [column.tolist() for column in table.columns] == [[0, 1, 2], [1, 2, 3], [2, 3, 4]]
