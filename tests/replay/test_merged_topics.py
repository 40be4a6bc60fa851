"""Exports in which each row holds one topic's columns only, as PlotJuggler's: all come to the times of one topic."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.traces.trace_table import read_table
from tests.trace_text import read_text, write_map

HEADER = "__time,/cmd/data,/joint/position,/joint/velocity"
SIGNALS = {
    "motor_torque": "{columns: ['/cmd/data'], unit: N m}",
    "speed": "{columns: [/joint/velocity], unit: rad/s}",
    "motor_position": "{columns: [/joint/position], unit: rad}",
}
TIMES = np.arange(100) * 0.01


def joint(time):
    return f"{time:.4f},,{time:.6f},1.0"


def command(time, value):
    return f"{time:.4f},{value:.6f},,"


def read(folder, rows, header=HEADER):
    """The table of these rows in the order of their times."""
    in_order = sorted(rows, key=lambda row: float(row.partition(",")[0]))
    return read_text(folder, "\n".join([header, *in_order, ""]), needed=lambda header: ())


def merged(folder):
    """Positions every 10 ms from 0 to 990 ms, and a torque that rises with time from 105 to 1095 ms."""
    return read(folder, [*map(joint, TIMES), *(command(t, t) for t in TIMES + 0.105)])


def test_values_are_interpolated_to_the_times_of_the_topic_with_most_numbers(tmp_path):
    table = merged(tmp_path)
    time, torque, position, speed = table.columns
    np.testing.assert_allclose(time, TIMES[11:])
    np.testing.assert_allclose(torque, time, atol=1e-9)
    np.testing.assert_allclose(position, time, atol=1e-9)
    assert (speed == 1.0).all() and table.decimals == [4, 6, 6, 6]
    [warning] = table.warnings
    assert "100 rows of /joint/position, /joint/velocity" in warning and "100 rows of /cmd/data" in warning
    assert "89 rows are used" in warning and "\n" not in warning
    assert table.line(0) == 14  # below the header, 11 rows of joints and one of the command


def test_a_map_reads_them_as_well_whichever_columns_it_needs(tmp_path):
    path = merged(tmp_path).path
    clock = "time: {column: __time, unit: s}"
    recording = load(path, import_map=write_map(tmp_path, SIGNALS, clock))
    np.testing.assert_allclose(recording.signals["motor_torque"], TIMES[11:], atol=1e-9)
    joint_alone = {name: columns for name, columns in SIGNALS.items() if name != "motor_torque"}
    without_command = load(path, import_map=write_map(tmp_path, joint_alone, clock))
    np.testing.assert_array_equal(without_command.stamps, recording.stamps)


def test_a_rare_command_stands_until_the_next_one_and_to_the_end(tmp_path):
    table = read(tmp_path, [*map(joint, TIMES), command(0.1001, 3.5), command(0.6001, 4.0)])
    np.testing.assert_array_equal(table.columns[1], np.where(table.columns[0] > 0.6, 4.0, 3.5))
    assert table.columns[0][[0, -1]].tolist() == [0.11, 0.99]


def test_an_angle_that_begins_again_is_not_interpolated_there(tmp_path):
    turned = [command(t, 100.0 * (t % 0.5)) for t in TIMES + 0.005]
    table = read(tmp_path, [*map(joint, TIMES), *turned])
    before = table.columns[1][:-1][np.diff(table.columns[1]) < -40.0]
    assert len(before) == 1 and before[0] > 49.0


def test_numbers_that_count_stay_whole(tmp_path):
    counts = [f"{t:.4f},{round(1000 * t)},," for t in TIMES + 0.003]
    table = read(tmp_path, [*map(joint, TIMES), *counts])
    np.testing.assert_array_equal(table.columns[1], np.rint(table.columns[1]))


def test_rows_that_hold_the_time_alone_are_left_out(tmp_path):
    rows = [*map(joint, TIMES), *(command(t, t) for t in TIMES + 0.005), *(f"{t:.4f},,," for t in TIMES + 0.007)]
    assert len(read(tmp_path, rows).columns[0]) == 99


def test_a_short_topic_does_not_shorten_the_recording(tmp_path):
    rows = [f"{joint(t)}," for t in TIMES] + [f"{command(t, t)}," for t in TIMES + 0.005]
    rows += [f"{t:.4f},,,,{t:.6f}" for t in TIMES[:20] + 0.007]
    table = read(tmp_path, rows, f"{HEADER},/imu/rate")
    assert len(table.columns[0]) == 99 and np.isnan(table.columns[4]).any()


def test_cells_that_are_empty_now_and_then_stay_so(tmp_path):
    rows = [f"{t:.4f},{'' if k in (7, 40) else k},{'' if k == 30 else k},1" for k, t in enumerate(TIMES)]
    table = read(tmp_path, rows)
    assert len(table.columns[0]) == 100 and np.isnan(table.columns[1]).sum() == 2 and table.warnings == ()
    with pytest.raises(InputError, match=r"line 9: column '/cmd/data': the cell is empty"):
        read_table(table.path)


def test_a_sensor_that_another_one_follows_takes_no_turns(tmp_path):
    rows = [joint(t) if t < 0.5 else command(t, t) for t in TIMES]
    assert len(read(tmp_path, rows).columns[0]) == 100
