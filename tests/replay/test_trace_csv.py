"""Text traces: which column is which signal, and each kind of bad input named."""

import math

import numpy as np
import pytest

from ema_bench_replay.load import load
from ema_bench_replay.recording import NO_DATE
from ema_bench_replay.traces.trace_table import read_table
from tests.trace_text import HEADER, ROWS, RPM, refused


def spoilt(old, new):
    """The lines of a trace in which the second row has something else in it."""
    return [HEADER, ROWS[0], ROWS[1].replace(old, new), *ROWS[2:], ""]


def test_reads_the_siemens_format(trace):
    recording = load(trace())
    assert recording.name == "run" and recording.start == NO_DATE and recording.warnings == ()
    assert recording.stamps.tolist() == [0, 2_000_000, 4_000_000, 6_000_000]
    assert list(recording.signals) == ["current", "current_setpoint", "motor_position", "output_position"]
    assert recording.signals["current"].tolist() == [0.1010, 0.1980, 0.2970, 0.4030]
    counts = recording.signals["output_position"] * 4_000_000 / (2 * math.pi)
    assert np.allclose(counts, [0, 3, 6, 9], atol=1e-9)
    assert recording.motor_angle_origin == pytest.approx(-math.pi)
    assert recording.output_angle_origin == pytest.approx(2 * math.pi * 999_998 / 4e6)
    assert recording.metadata["source"] == "run.csv" and recording.metadata["map"] == "siemens"
    assert len(recording.metadata["sha256"]) == 64 and "r4821" in recording.metadata["map_text"]


@pytest.mark.parametrize("spelling", ["r482[1]", "r482.1", "r4821", "r04821", "R4821", "Drive_axis_1.r482[1]"])
def test_spellings_of_a_parameter(trace, spelling):
    header = HEADER.replace("Drive_axis_1.r4821", spelling)
    assert load(trace(header=header)).has("output_position")


def test_columns_are_found_by_number_not_by_place(trace):
    order = [3, 0, 4, 2, 1]
    cells = [line.split(";") for line in [HEADER, *ROWS]]
    lines = [";".join(line[place] for place in order) + ";" for line in cells]
    turned = load(trace(header=lines[0], rows=lines[1:]))
    for name, values in load(trace(name="other.csv")).signals.items():
        assert np.array_equal(values, turned.signals[name])


def test_speed_is_in_rad_per_second(trace):
    recording = load(trace(header="X [ms];r62;r63;r1733;", rows=["0,0;1.145,5;60,0;0,5;", "2,0;0,0;-1,0;0,5;"]))
    assert recording.signals["speed_setpoint"].tolist() == [1145.5 * RPM, 0.0]
    assert recording.signals["speed"].tolist() == [60.0 * RPM, -1.0 * RPM]


def test_time_unit_in_brackets_goes_first(trace):
    recording = load(trace(header="Time [s];r77;", rows=["0,000;0,1;", "0,002;0,1;", "0,004;0,1;"]))
    assert recording.stamps.tolist() == [0, 2_000_000, 4_000_000]


def test_a_trace_that_begins_late_begins_at_zero(trace):
    recording = load(trace(rows=[row.replace(",", "0,", 1) for row in ROWS]))
    assert recording.stamps.tolist() == [0, 20_000_000, 40_000_000, 60_000_000]


def test_what_no_signal_needs_may_hold_anything(trace):
    """Words, dates, empty cells: nobody reads that column."""
    rows = [f"{row}{text};" for row, text in zip(ROWS, ("settling", "", "1.2,3.4", "8.6.2026"), strict=True)]
    plain, worded = load(trace(name="plain.csv")), load(trace(header=HEADER + "phase;", rows=rows))
    for name, values in plain.signals.items():
        assert np.array_equal(values, worded.signals[name])
    assert worded.warnings == ()


def test_time_that_repeats_now_and_then_is_left_out(trace):
    """A clock too coarse for its sampling; the lines that are told later are still those of the file."""
    rows = [f"{time},0;{value:.1f};".replace(".", ",") for time, value in zip(range(0, 40, 2), range(20), strict=True)]
    doubled = [*rows[:5], rows[4], *rows[5:]]
    recording = load(trace(header="X [ms];r77;", rows=doubled))
    assert np.array_equal(recording.signals["current_setpoint"], np.arange(20.0))
    assert "1 row (the first in line 7)" in recording.warnings[0] and "left out" in recording.warnings[0]


class TestCurrent:
    """r78 is the torque-generating current; r76 is taken for it only where it follows r77."""

    times = np.arange(0, 200, 2)
    setpoint = np.sin(times / 30)

    def rows(self, *columns):
        lines = np.column_stack([self.times, *columns])
        return [";".join(f"{value:.4f}".replace(".", ",") for value in line) + ";" for line in lines]

    def test_r78_is_preferred(self, trace):
        rows = self.rows(self.setpoint, 0 * self.setpoint, 0.9 * self.setpoint)
        recording = load(trace(header="X [ms];r77;r76;r78[1];", rows=rows))
        assert np.allclose(recording.signals["current"], 0.9 * self.setpoint, atol=1e-4) and not recording.warnings

    def test_r76_that_does_not_follow_is_replaced(self, trace):
        rows = self.rows(self.setpoint, 0.2 * self.setpoint + 1)
        recording = load(trace(header="X [ms];r77;r76;", rows=rows))
        assert np.array_equal(recording.signals["current"], recording.signals["current_setpoint"])
        [warning] = recording.warnings
        assert "r76 hardly follows r77 (slope 0.20" in warning

    def test_r76_that_follows_is_taken(self, trace):
        recording = load(trace(header="X [ms];r77;r76;", rows=self.rows(self.setpoint, 0.8 * self.setpoint)))
        assert np.allclose(recording.signals["current"], 0.8 * self.setpoint, atol=1e-4) and not recording.warnings

    def test_a_setpoint_at_rest_proves_nothing(self, trace):
        noise = np.random.default_rng(1).normal(0, 3e-3, len(self.times))
        rows = self.rows(0 * self.setpoint + 0.5, 0.5 + noise)
        assert not load(trace(header="X [ms];r77;r76;", rows=rows)).warnings

    def test_r76_alone_is_taken(self, trace):
        assert not load(trace(header="X [ms];r76;", rows=self.rows(self.setpoint))).warnings


def test_the_same_parameter_twice_is_said(trace):
    header = "X [ms];Drive_axis_1.r63;Drive_axis_2.r63;"
    [warning] = load(trace(header=header, rows=["0,0;1,0;2,0;", "2,0;1,0;2,0;"])).warnings
    assert "r63 is in 2 columns" in warning and "column 2 is used" in warning


def test_gaps_and_unequal_steps_are_said(trace):
    times = [*range(0, 40, 2), *range(60, 100, 2), *range(104, 120, 2)]
    recording = load(trace(header="X [ms];r77;", rows=[f"{t},0;0,1;" for t in times]))
    [warning] = recording.warnings
    assert "12 samples are missing in 2 gaps, the longest 22 ms from 0.038 s on" in warning
    assert [(gap.time, gap.missing) for gap in recording.gaps] == [(0.038, 10), (0.098, 2)]
    uneven = load(trace(header="X [ms];r77;", rows=[f"{t};0,1;" for t in ("0,0", "2,0", "4,3", "6,0", "8,0")]))
    [warning] = uneven.warnings
    assert "unequal: 1.7 to 2.3 ms" in warning and not uneven.gaps


def test_rounded_times_are_not_unequal(trace):
    times = [f"{round(1.25 * k, 1):.1f}".replace(".", ",") for k in range(100)]
    assert not load(trace(header="X [ms];r77;", rows=[f"{t};0,1;" for t in times])).warnings


@pytest.mark.parametrize(
    "cut", ["6,0;1.000.00", "6,0;1.000.007;-20.450;0,4000;0,40", "6", "6,0;1.000.007;-20.450;0,4000;0,4030"]
)
def test_a_torn_last_row_is_left_out(trace, cut):
    recording = load(trace("\r\n".join([HEADER, *ROWS[:3], cut]).encode()))
    assert len(recording) == 3
    assert recording.warnings == ("run.csv: line 5: the last row is cut, so only the rows before it can be used",)


def test_a_torn_row_with_a_line_end_or_zeros_behind_it(trace):
    assert len(load(trace("\n".join([HEADER, *ROWS[:3], "6,0;1.0", ""]).encode()))) == 3
    assert len(load(trace("\n".join([HEADER, *ROWS[:3], "6,0;1.0"]).encode() + bytes(5000)))) == 3


def test_a_last_line_without_end_is_whole(trace):
    assert len(load(trace("\n".join([HEADER, *ROWS]).encode()))) == 4
    untrailed = [line.rstrip(";") for line in [HEADER, *ROWS]]
    assert len(load(trace("\n".join(untrailed).encode()))) == 4
    assert len(load(trace("\n".join(untrailed).encode()[:-1]))) == 3


@pytest.mark.parametrize(
    "end",
    [
        "\r\n\r\n\r\n",
        "\n\n# fitted\n# a -> 0.03; 0,05\n",
        "\n# fitted",
        "\n% a\n\n% b\n",
        "\n  \n\t\n",
        "\n" + "# a\n" * 300,
    ],
)
def test_comments_below_the_rows_are_ignored_as_above_the_header(trace, end):
    recording = load(trace(("\n".join([HEADER, *ROWS]) + end).encode()))
    assert len(recording) == 4 and recording.warnings == ()


@pytest.mark.parametrize("cell", ["-1.#IO", "1.#QNAN", "nan", "", "OFF", "0,4.1"])
def test_a_last_row_that_is_no_number_is_left_out_and_said(trace, cell):
    recording = load(trace(rows=[*ROWS, f"8,0;1.000.010;-20.440;{cell};0,5;"]))
    assert len(recording) == 4
    [warning] = recording.warnings
    assert warning.startswith("run.csv: line 6: the last row is left out, since its column 'C4:Drive_axis_1.r77'")


def test_such_a_row_elsewhere_or_alone_is_refused(trace):
    spoilt = "8,0;1.000.010;-20.440;-1.#IO;0,5;"
    refused(trace(rows=[*ROWS[:2], spoilt, *ROWS[2:]]), "line 4", "'C4:Drive_axis_1.r77'", "'-1.#IO' is no number")
    refused(trace(rows=[spoilt]), "line 2", "'-1.#IO' is no number")


def test_words_in_a_column_of_words_leave_no_row_out(trace):
    table = read_table(trace(header="t;state", rows=["0,5;RUN", "1,5;OFF"]), needed=lambda header: ())
    assert table.columns[0].tolist() == [0.5, 1.5] and table.warnings == ()


def test_a_comment_between_rows_is_refused(trace):
    refused(trace("\n".join([HEADER, *ROWS[:2], "# pause", *ROWS[2:], ""]).encode()), "line 4", "1 cell", "remove")


NO_NUMBERS = {"NaN": "(NaN)", "nan": "(NaN)", **{word: repr(word) for word in ("-inf", "1.#QNAN", "#NV", "--")}}
"""What stands in the place of a number, and how that is told."""


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], ["is empty"]),
        (["", "", ""], ["export"]),
        ([HEADER, ""], ["no rows"]),
        ([HEADER], ["no rows"]),
        ([HEADER, *ROWS[:1], ""], ["one row"]),
        ([HEADER.replace("X [ms]", "Y"), *ROWS, ""], ["line 1", "no time column"]),
        (["X [ms];r1;r2;r3;r4;", *ROWS, ""], ["'siemens'", "r4821", "--map"]),
        (spoilt("0,2000", "0,2x00"), ["line 3", "'C4:Drive_axis_1.r77'", "'0,2x00' is no number"]),
        *((spoilt("0,2000", word), ["line 3", "r77", told]) for word, told in NO_NUMBERS.items()),
        (spoilt("0,2000", ""), ["line 3", "r77", "empty"]),
        (spoilt("0,2000;", ""), ["line 3", "4 cells", "5"]),
        (spoilt("1.000.001", "1.00.001"), ["line 3", "1.00.001"]),  # a group of thousands
        ([HEADER, *ROWS[:3], ROWS[1], ""], ["line 5", "'X [ms]'", "goes back", "2 ms after 4 ms"]),
        (["# a", "# b", HEADER, *ROWS[:3], ROWS[1], ""], ["line 7", "goes back"]),
        ([HEADER, ROWS[0], ROWS[0], ""], ["line 3", "repeats", "1 of 2 rows"]),
    ],
)
def test_bad_input_is_one_line_with_file_place_and_remedy(trace, lines, words):
    refused(trace("\r\n".join(lines).encode()), *words)


def test_files_that_are_no_texts_are_refused(trace, tmp_path):
    refused(trace(bytes(range(256)) * 40), "run.csv")
    refused(tmp_path / "none.csv", "no such file")
    refused(trace(name="run.xlsx"), ".xlsx", "mcap")
