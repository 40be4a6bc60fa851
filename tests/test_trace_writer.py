"""Text traces are written as they were read, and so that their map reads them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trace_text import HEADER, SIEMENS

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.traces.trace_csv import read_trace, write_trace


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
