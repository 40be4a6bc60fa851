"""Text traces are written as they were read, and so that their map reads them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ema_bench_replay.configuration import find_configuration
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import POINTS, Recording
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.trace_csv import read_trace
from ema_bench_replay.traces.trace_writer import write_trace
from tests.trace_text import HEADER, SIEMENS, write_map

SPEED_AND_CURRENT = {"speed": "{columns: ['speed .*']}", "current": "{columns: ['current .*']}"}


def original_and_written(path, tmp_path):
    out = tmp_path / "written" / path.name
    assert write_trace(read_trace(path, SIEMENS), out, SIEMENS) == ()
    return path.read_bytes(), out.read_bytes()


def test_the_text_comes_back(trace, tmp_path):
    written, read = original_and_written(trace(), tmp_path)
    assert written == read


def test_recorded_traces_come_back(traces, tmp_path):
    for path in traces:
        written, read = original_and_written(path, tmp_path)
        # A drive may print -0 for a count of 0; a count has no sign to keep.
        assert written.replace(b";-0;", b";0;") == read


@given(
    st.lists(
        st.tuples(st.integers(-999_999_999, 999_999_999), st.integers(-999_999, 999_999)), min_size=2, max_size=20
    ),
    st.sampled_from([(";", ",", "."), (";", ".", ","), ("\t", ".", ""), (",", ".", "")]),
)
@settings(deadline=None)
def test_any_text_comes_back(tmp_path_factory, rows, style):
    """Counts, decimals, delimiters and number formats are what they were, whatever they were."""
    delimiter, decimal, thousands = style
    folder = tmp_path_factory.mktemp("back")
    cells = [f"{2 * k:,.1f}\0{count // 1000:,d}\0{value / 1e4:,.4f}" for k, (count, value) in enumerate(rows)]
    marks = {",": thousands, ".": decimal, "\0": delimiter}
    lines = ["".join(marks.get(letter, letter) for letter in line) for line in cells]
    path = folder / "run.csv"
    path.write_text("\n".join([delimiter.join(["X [ms]", "r4820", "r77"]), *lines, ""]))
    recording = read_trace(path, SIEMENS)
    if not any("repaired" in warning for warning in recording.warnings):
        write_trace(recording, folder / "back.csv", SIEMENS)
        assert (folder / "back.csv").read_text() == path.read_text().replace(
            delimiter + "-0" + delimiter, delimiter + "0" + delimiter
        )


def test_a_recording_without_text_is_written_as_siemens_would(trace, tmp_path):
    recording = load(trace())
    bare = type(recording)("bare", recording.stamps, {**recording.signals, "temperature": np.full(4, 20.0)})
    assert write_trace(bare, tmp_path / "bare.csv", SIEMENS) == ("temperature",)
    lines = (tmp_path / "bare.csv").read_text().splitlines()
    assert lines[0] == HEADER.replace("C4:", "C2:").replace("C5:", "C3:")
    assert lines[2] == "2,0;3;10;0,2000;0,1980;"
    again = load(tmp_path / "bare.csv")
    assert np.array_equal(again.signals["current"], recording.signals["current"])


def test_an_existing_trace_is_not_overwritten(trace):
    path = trace()
    with pytest.raises(InputError, match="exists already"):
        write_trace(load(path), path, SIEMENS)
    write_trace(load(path), path, SIEMENS, force=True)


def assert_same_recording(one, other):
    assert np.array_equal(one.stamps, other.stamps) and list(one.signals) == list(other.signals)
    for name, values in one.signals.items():
        assert np.allclose(values, other.signals[name], rtol=0.0, atol=1e-14 * np.abs(values).max()), name


def test_decimals_that_the_first_rows_do_not_show_are_kept(tmp_path):
    rows = [f"{k},0,1" for k in range(60)] + ["59.987654321,0.123456789012,2.5e-7", "60.5,1e-9,1e3"]
    (tmp_path / "points.csv").write_text("\n".join(["time [s],speed [rad/s],current [A]", *rows, ""]))
    own = load_map(write_map(tmp_path, SPEED_AND_CURRENT, "operating_points: true\ntime: {column: 'time .*', unit: s}"))
    recording = read_trace(tmp_path / "points.csv", own)
    write_trace(recording, tmp_path / "back.csv", own)
    assert_same_recording(recording, read_trace(tmp_path / "back.csv", own))


def test_points_without_time_are_written_without(tmp_path):
    (tmp_path / "curve.csv").write_text("current [A];speed [rad/s]\n0,1;1\n0,25;2,5\n")
    own = load_map(write_map(tmp_path, SPEED_AND_CURRENT, "operating_points: true"))
    recording = read_trace(tmp_path / "curve.csv", own)
    write_trace(recording, tmp_path / "back.csv", own)
    assert (tmp_path / "back.csv").read_text() == "current [A];speed [rad/s]\n0,10;1,0\n0,25;2,5\n"
    bare = Recording("bare", recording.stamps, recording.signals, metadata={POINTS: "yes"})
    write_trace(bare, tmp_path / "bare.csv", own)
    assert_same_recording(recording, read_trace(tmp_path / "bare.csv", own))


def test_a_unit_in_the_header_of_the_time_holds_for_what_is_written(tmp_path):
    rows = "".join(f"{0.002 * k:.3f},{k}\n" for k in range(4))
    (tmp_path / "run.csv").write_text("Time [s],r4820\n" + rows)
    recording = read_trace(tmp_path / "run.csv", SIEMENS)
    write_trace(recording, tmp_path / "back.csv", SIEMENS)
    assert (tmp_path / "back.csv").read_text() == "Time [s],r4820\n" + rows


@pytest.mark.parametrize("form", ["delimiter: ','", "number_format: english", "delimiter: tab"])
def test_what_no_trace_was_read_for_is_written_so_that_its_map_reads_it(tmp_path, form):
    clock = r"time: {column: 't \[ms\]', unit: ms}"
    signals = {"motor_position": r"{columns: ['path \[mm\]'], unit: mm}"}
    own = load_map(write_map(tmp_path, signals, f"motion: linear\n{form}\n{clock}"))
    positions = np.cumsum(np.random.default_rng(2).normal(size=40)) * 1e-5
    recording = Recording("made", np.arange(40) * 125_000, {"motor_position": positions - positions[0]})
    write_trace(recording, tmp_path / "made.csv", own)
    assert (tmp_path / "made.csv").read_text().startswith("t [ms]")
    assert "path [mm]" in (tmp_path / "made.csv").read_text()
    assert_same_recording(recording, read_trace(tmp_path / "made.csv", own))


def test_a_table_of_points_comes_back(real, tmp_path):
    laas = load_map("laas")
    recording = read_trace(real / "laas_holding_current.csv", laas)
    write_trace(recording, tmp_path / "back.csv", laas)
    assert_same_recording(recording, read_trace(tmp_path / "back.csv", laas))


def test_a_column_of_a_whole_name_is_written_so_that_the_same_map_reads_it(tmp_path):
    """The drive's prefix belongs to the numbers of its parameters."""
    shipped = find_configuration("maps", "siemens").read_text()
    own = tmp_path / "own.yaml"
    own.write_text(f"{shipped}  temperature: {{columns: [winding]}}\n")
    stamps = np.arange(4) * 2_000_000
    signals = {"current": np.linspace(0.0, 1.0, 4), "temperature": np.array([20.0, 20.5, 21.0, 21.5])}
    recording = Recording("run", stamps, signals)
    write_trace(recording, tmp_path / "run.csv", load_map(own))
    again = read_trace(tmp_path / "run.csv", load_map(own))
    assert {*again.signals} == {*signals}
    assert np.allclose(again.signals["temperature"], signals["temperature"])
