"""Traces that hold many runs, positions told by their error, and currents that are magnitudes."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.many_runs import read_runs
from ema_bench_replay.traces.run_columns import count_of_runs, run_columns
from ema_twin_sim.health import MotionRecord
from ema_twin_sim.model import load_model
from ema_twin_sim.model.matching import matched
from tests.trace_text import write_map

HEADER = "sequence,test,time [s],set_point [mm],position_error [mm],current [A]"
ROWS = [
    *("1,1,0.00,20.0,0.5,0.3", "1,1,0.04,21.0,0.4,0.4", "1,1,0.08,22.0,0.2,0.5"),
    *("2,3,0.00,20.0,-0.5,0.3", "2,3,0.04,21.0,0.1,0.2", "2,3,0.08,22.0,0.0,0.1"),
]


def trace(folder, rows=ROWS):
    path = folder / "runs.csv"
    path.write_text("\n".join([HEADER, *rows]) + "\n")
    return path


def test_each_run_of_a_file_is_a_recording(tmp_path):
    first, second = read_runs(trace(tmp_path), load_map("cranfield_ball_screw"))
    assert (first.name, second.name) == ("runs_1", "runs_2")
    assert (first.metadata["test"], second.metadata["test"]) == ("1", "3")
    assert len(first) == len(second) == 3 and first.motion == "linear"
    assert second.time == pytest.approx([0.0, 0.04, 0.08])
    assert second.signals["current"] == pytest.approx([0.3, 0.2, 0.1])


def test_a_position_is_the_set_point_less_its_error(tmp_path):
    first, _ = read_runs(trace(tmp_path), load_map("cranfield_ball_screw"))
    difference = first.signals["output_command"] - first.signals["output_position"]
    assert difference == pytest.approx([5e-4, 4e-4, 2e-4])
    record = MotionRecord.from_recording(first, first.metadata["test"])
    assert record.command == pytest.approx([0.020, 0.021, 0.022])  # from the encoder's zero, where waves repeat
    assert record.unsigned and record.position_unit == "m" and record.effort_unit == "A"


def test_a_magnitude_drives_no_twin(tmp_path):
    first, _ = read_runs(trace(tmp_path), load_map("cranfield_ball_screw"))
    taken = matched(first, load_model("emps"))
    assert "current" not in taken.signals and "current" in first.signals
    assert "the current is a magnitude, which does not tell which way it acts: left out" in taken.warnings[-1]


def test_a_run_is_of_one_test(tmp_path):
    rows = [*ROWS[:2], "1,2,0.08,22.0,0.2,0.5"]
    with pytest.raises(InputError, match="run 1 is of tests 1 and 2; number runs on from test to test"):
        read_runs(trace(tmp_path, rows), load_map("cranfield_ball_screw"))


def test_a_file_without_the_columns_is_refused(tmp_path):
    path = tmp_path / "other.csv"
    path.write_text("time [s],set_point [mm],position_error [mm],current [A]\n0,1,0,1\n1,2,0,1\n")
    with pytest.raises(InputError, match="no column 'sequence' tells the run of a row"):
        read_runs(path, load_map("cranfield_ball_screw"))


def test_a_map_without_runs_reads_one(tmp_path):
    path = tmp_path / "motion.csv"
    path.write_text("time [s],position [m],position_setpoint [m],control_voltage [V]\n0,1,1,1\n0.1,2,2,1\n")
    (only,) = read_runs(path, load_map("emps"))
    assert isinstance(only, Recording) and np.isfinite(only.signals["motor_torque"]).all()


def test_only_currents_and_torques_may_be_magnitudes(tmp_path):
    own = write_map(tmp_path, {"speed": "{columns: [v], magnitude: true}"})
    with pytest.raises(InputError, match="magnitude"):
        load_map(own)


def test_how_to_read_a_file_of_many_runs_is_told_where_its_time_goes_back(tmp_path):
    path = trace(tmp_path)
    with pytest.raises(InputError, match=r"one run; ema-twin campaign reads each by itself, as .*run: sequence"):
        load(path, import_map="cranfield_ball_screw")
    plain = write_map(tmp_path, {"current": "{columns: [current.*], unit: A}"}, "time: {column: 'time.*', unit: s}")
    with pytest.raises(InputError, match=r"one run; or, with `run: sequence` in the import map, ema-twin campaign"):
        load(path, import_map=plain)


@pytest.mark.parametrize(
    ("numbers", "count"),
    [
        ([1, 1, 2, 2, 5, 5, 5], 3),
        ([7, 7, 7], 1),
        ([1, 1, 2, 2, 1, 1], 0),
        ([20, 21, 22, 24], 0),
        ([20.5, 20.5, 21, 21], 0),
    ],
    ids=["runs", "one", "returns", "one row each", "parts"],
)
def test_a_column_numbers_runs_if_the_rows_of_each_follow_each_other(numbers, count):
    assert run_columns(["test", "run no", "Lauf", "current [A]"]) == ["run no", "Lauf", "test"]
    assert count_of_runs(np.array(numbers, dtype=float)) == count
