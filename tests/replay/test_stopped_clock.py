"""A log whose clock stopped before it did, and one whose clock repeats itself."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from tests.command_line import done
from tests.trace_text import write_map


def written(tmp_path, time):
    """A log of a shaft that turns by 0.01 rad a row."""
    rows = [f"{t:.4f},{0.01 * k:.4f},{0.5:.1f}" for k, t in enumerate(time)]
    (tmp_path / "log.csv").write_text("\n".join(["time [s],angle [rad],torque [N m]", *rows]) + "\n")
    return tmp_path / "log.csv"


def read(tmp_path, time):
    own = write_map(tmp_path, {"motor_position": "{columns: [angle .*]}"}, "time: {column: time .*, unit: s}")
    return load(written(tmp_path, time), import_map=own)


def clock(count, stopped, every=0):
    """Time (n,) of a clock of 10 ms that stops for the last rows; ``every`` so many rows it repeats a time."""
    time = np.arange(count) * 0.01
    if every:
        time[every::every] = time[every - 1 :: every][: len(time[every::every])]
    return np.concatenate([time, np.full(stopped, time[-1])])


@pytest.mark.parametrize("every", [0, 25])
def test_rows_after_the_clock_stopped_are_left_out_and_said(tmp_path, every):
    recording = read(tmp_path, clock(300, 120, every))
    said = (
        "log.csv: the clock stops in line 301, at 2.99 s: the 120 rows below it, which tell the same time, are left out"
    )
    assert said in recording.warnings
    few = [warning for warning in recording.warnings if "tell the time of the row before" in warning]
    assert few == (
        ["log.csv: 11 rows (the first in line 27) tell the time of the row before: left out"] if every else []
    )
    assert len(recording) == 300 - 11 * bool(every)
    assert recording.signals["motor_position"][-1] == pytest.approx(2.99)
    assert recording.sample_period == pytest.approx(0.01)


def test_a_clock_that_stood_most_of_the_time_is_refused_with_what_to_cut(tmp_path):
    with pytest.raises(InputError, match=r"line 102: .*time stops .*all 150 rows from here on tell the same: cut them"):
        read(tmp_path, clock(100, 150))


def test_a_clock_that_is_too_coarse_throughout_needs_decimals(tmp_path):
    with pytest.raises(InputError, match=r"200 of 400 rows do: export it with more decimals"):
        read(tmp_path, np.repeat(np.arange(200) * 0.01, 2))


def test_init_drafts_from_such_a_log(tmp_path):
    written(tmp_path, clock(300, 120))
    drafted = done("init", "log.csv", "-o", "own", cwd=tmp_path)
    assert "the clock stops in line 301" in drafted.stderr
    assert "sample_period: {value: 0.01," in (tmp_path / "own.yaml").read_text()
