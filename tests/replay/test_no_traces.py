"""Files that are no traces, or whose time falls: what is wrong with them is said by its name."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError, TimeGoesBackError
from ema_bench_replay.load import load
from tests.one_line import refused_in_one_line
from tests.trace_text import read_text, write_columns, write_map

SIGNALS, CLOCK = {"current": "{columns: [current], unit: A}"}, "time: {column: time, unit: s}"
TIME = np.arange(50) * 0.01


def read(tmp_path, time):
    file = write_columns(tmp_path / "run.csv", {"time": time, "current": np.sin(np.arange(len(time)))})
    return load(file, import_map=write_map(tmp_path, SIGNALS, CLOCK))


@pytest.mark.parametrize("time", [TIME[::-1], np.repeat(TIME[::-1], 2), TIME[:3][::-1]])
def test_a_time_that_falls_throughout_is_to_be_sorted(tmp_path, time):
    """It was to be cut, as if it held more than one run."""
    said = r"time falls .* from row to row throughout: sort the rows by their time, or reverse them"
    with pytest.raises(TimeGoesBackError, match=said):
        read(tmp_path, time)


@pytest.mark.parametrize("time", [np.tile(TIME, 2), np.concatenate([TIME[::-1], TIME])])
def test_one_that_also_rises_holds_more_than_one_run(tmp_path, time):
    with pytest.raises(TimeGoesBackError, match=r"time goes back .* more than one run"):
        read(tmp_path, time)


@pytest.mark.parametrize(
    ("row", "value", "line"),
    [
        (20, 0.05, 22),  # too early
        (20, 7.0, 22),  # too late
        (49, 0.05, 51),  # the last one
    ],
)
def test_a_single_row_out_of_order_is_to_be_removed(tmp_path, row, value, line):
    """It was taken for the beginning of a second run."""
    time = TIME.copy()
    time[row] = value
    said = rf"time goes back .*only the row of {value:g} s lies out of order.*: remove line {line}$"
    with pytest.raises(TimeGoesBackError, match=said):
        read(tmp_path, time)
    assert len(read(tmp_path, np.delete(time, row)).time) == len(TIME) - 1


def test_single_rows_out_of_order_are_told_together(tmp_path):
    time = np.arange(300) * 0.01
    time[[30, 200]] = 0.1, 9.0
    with pytest.raises(TimeGoesBackError, match=r"2 single rows lie out of order.*: remove lines 32, 202$"):
        read(tmp_path, time)


def test_clocks_that_take_turns_are_no_single_rows(tmp_path):
    time = np.where(np.arange(50) % 2, TIME + 100.0, TIME)
    with pytest.raises(TimeGoesBackError, match="more than one run"):
        read(tmp_path, time)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("size", [2_000, 200_000])
def test_random_bytes_are_no_text(tmp_path, seed, size):
    """Their rows had the wrong number of cells."""
    with pytest.raises(InputError, match="is no text; give the drive's trace exported as CSV"):
        read_text(tmp_path, np.random.default_rng(seed).bytes(size))


def test_numbers_of_a_computers_memory_are_no_text_either(tmp_path):
    with pytest.raises(InputError, match="is no text"):
        read_text(tmp_path, b"time,current\n" + np.linspace(0.0, 1.0, 3000).tobytes() + b"\n")


def test_json_is_no_table(tmp_path):
    """Each record's names and numbers were read as the cells of a row."""
    with pytest.raises(InputError, match="line 1: is JSON; write it as CSV"):
        read_text(tmp_path, "".join(f'{{"t":{time:.3f},"rpm":{9 * time:.2f}}}\n' for time in TIME))


@pytest.mark.parametrize("kind", ["csv", "txt", "tsv", "dat", "asc", "log", "DAT"])
def test_a_text_is_read_whatever_its_name_ends_in_and_a_binary_file_is_refused(tmp_path, kind):
    file = tmp_path / f"run.{kind}"
    own = write_map(tmp_path, SIGNALS, CLOCK)
    file.write_text("time current\n" + "".join(f"{time:.3f} {time:.1f}\n" for time in TIME))
    assert len(load(file, import_map=own)) == len(TIME)
    file.write_bytes(b"MDF     3.00" + bytes(range(256)) * 40)
    with refused_in_one_line(file, "is no text; give the drive's trace exported as CSV"):
        load(file, import_map=own)


ROWS = "".join(f"{k},{k * k}\n" for k in range(40))


@pytest.mark.parametrize(
    "content",
    [
        f"time,Größe [°]\n{ROWS}".encode(),
        f"time,Größe [°]\n{ROWS}".encode("latin-1"),
        f"time,angle\n{ROWS}".encode("utf-16"),
        f"time,angle\n{ROWS}".encode("utf-16-le"),
        f"time,angle\n{ROWS}".encode("utf-8-sig"),
        f"時間,電流\n{ROWS}".encode("shift-jis"),
        f"time,angle\n{ROWS}".encode() + bytes(5000),  # preallocated space
        f"time,angle\n{ROWS}\x1a".encode(),  # the end of a file in DOS
    ],
)
def test_texts_of_any_encoding_are_text(tmp_path, content):
    assert len(read_text(tmp_path, content, needed=lambda header: ()).columns[0]) >= 40
