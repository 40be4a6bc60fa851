"""Text traces: every format that a drive and Windows may write, values exact."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.traces.number_format import ENGLISH, GERMAN
from tests.trace_text import HEADER, ROWS, SIEMENS, read_text, refused


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-16-le"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_encodings_of_windows(trace, encoding, newline):
    text = newline.join(["# Prüfstand", HEADER.replace("r77", "r77 Größe"), *ROWS, ""])
    recording = load(trace(text.encode(encoding)))
    assert len(recording) == 4 and recording.signals["current_setpoint"][1] == 0.2


def test_preamble_of_comments_and_quoted_text(trace):
    text = "\n".join(['"Trace of 17.04., axis 1; ramp"', "", "# 2 ms", "sep=;", HEADER, *ROWS, ""])
    assert len(load(trace(text.encode()))) == 4


@pytest.mark.parametrize(
    ("delimiter", "cells"),
    [
        (";", ["0.0", "1,445,660", "0.25"]),
        (";", ["0.0", "1445660", "0.25"]),
        ("\t", ["0.0", "1,445,660.0", "2.5e-1"]),
        ("\t", ["0,0", "1.445.660,0", "0,25"]),
        (",", ["0.0", "1445660", "0.25"]),
        (",", ["0.0", '"1,445,660"', "0.25"]),
        (",", ['"0,0"', '"1.445.660"', '"0,25"']),
        ("; ", ["0,0", "1.445.660", "0,25"]),
    ],
)
def test_number_formats_and_delimiters(trace, delimiter, cells):
    second = [cells[0].replace("0", "2", 1), cells[1].replace("660", "661"), cells[2]]
    lines = [delimiter.join(line) for line in (["X [ms]", "r4821", "r77"], cells, second)]
    recording = load(trace("\n".join([*lines, ""]).encode()))
    assert recording.warnings == ()
    assert recording.output_angle_origin == pytest.approx(2 * math.pi * 1_445_660 / 4e6, rel=1e-12)
    assert recording.signals["current_setpoint"].tolist() == [0.25, 0.25]


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("columns", [2, 3, 4, 6])
def test_the_number_of_rows_decides_nothing(tmp_path, columns, delimiter):
    """The names hold blanks, and the rows go on behind the lines among which the first row of numbers must be."""
    names = ["time [s]", "motor speed [rad/s]", "motor current [A]", "motor position [rad]", "bus [V]", "case [degC]"]
    header = delimiter.join(names[:columns])
    for rows in range(195, 231):
        cells = [delimiter.join(f"{row + 0.25 * column:.5f}" for column in range(columns)) for row in range(rows)]
        table = read_text(tmp_path, "\n".join([header, *cells, ""]))
        assert table.header == names[:columns]
        assert [len(column) for column in table.columns] == [rows] * columns
        assert [column[-1] for column in table.columns] == [rows - 1 + 0.25 * column for column in range(columns)]


@pytest.mark.parametrize("rows", [1, 198, 199, 200, 201, 230])
def test_columns_of_blanks_are_read_with_any_number_of_rows(tmp_path, rows):
    table = read_text(tmp_path, "time speed current\n" + "".join(f"{row} {row}.5 {row}.25\n" for row in range(rows)))
    assert table.header == ["time", "speed", "current"]
    assert table.columns[2].tolist() == [row + 0.25 for row in range(rows)]


@pytest.mark.parametrize(
    "word", ["ticks", "tick", "Counts", "pulses", "increments", "Inkremente", "steps", "raw", "rpm"]
)
def test_a_row_of_units_is_known_by_its_words(tmp_path, word):
    table = read_text(tmp_path, f"Time;Position;Speed\nms;{word};rad/s\n0;1;2\n1;2;2\n")
    assert table.header == ["Time [ms]", f"Position [{word}]", "Speed [rad/s]"]


@pytest.mark.parametrize("end", ["", ";"])
def test_units_between_names_and_short_names_are_those_of_the_names(tmp_path, end):
    rows = ["Time;Set speed;Position", "ms;rad/s;ticks", "t;m1setvel;m1pos", "0;1;2", "1;2;2"]
    table = read_text(tmp_path, "".join(f"{row}{end}\n" for row in rows))
    assert table.header == ["Time [ms]", "Set speed [rad/s]", "Position [ticks]"]
    assert [column.tolist() for column in table.columns] == [[0.0, 1.0], [1.0, 2.0], [2.0, 2.0]]
    assert table.line(0) == 4


@pytest.mark.parametrize("above", ["", "Motor;Motor;Motor\n"])
def test_names_below_their_units_have_these(tmp_path, above):
    """A line of groups above them names no column."""
    table = read_text(tmp_path, f"{above}ms;rad/s;ticks\nt;speed;position\n0;1;2\n1;2;2\n")
    assert table.header == ["t [ms]", "speed [rad/s]", "position [ticks]"]


def test_thousands_in_a_german_file_are_not_decimals(trace):
    recording = load(trace(rows=["0,0;812.347;1.445;0,1;0,1;", "2,0;812.348;1.446;0,2;0,2;"]))
    assert recording.output_angle_origin == pytest.approx(2 * math.pi * 812_347 / 4e6)
    assert recording.motor_angle_origin == pytest.approx(2 * math.pi * 1445 / 40960)


def test_time_tells_what_a_mark_means(trace):
    header = "X [ms];r4821;"
    thousands = load(trace(header=header, rows=[f"{t};812.347;" for t in ("998", "999", "1.000", "1.001")]))
    assert thousands.stamps.tolist() == [0, 1_000_000, 2_000_000, 3_000_000] and thousands.warnings == ()
    assert thousands.output_angle_origin == pytest.approx(2 * math.pi * 812_347 / 4e6)


@pytest.mark.parametrize(
    "words",
    ['"[0.1{}, -0.{}, 3.2{}]"', '"1,{} of 2,{}"', '"(0,{})"', '"12,{} %"'],
    ids=["list", "text", "brackets", "share"],
)
def test_only_a_whole_number_tells_the_decimal_mark(tmp_path, words):
    """The commas of a list in a cell are no decimal marks."""
    rows = [f"on,{row}.5,{words.format(*[10 + row, 20 + row, 30 + row])}" for row in range(9)]
    text = "\n".join(["state,time [s],note", *rows, "on,9.75,-", ""])
    table = read_text(tmp_path, text, needed=lambda header: (1,))
    assert table.columns[1].tolist() == [*(row + 0.5 for row in range(9)), 9.75]


@pytest.mark.parametrize("cell", ["1,5e-3", "-0,25", "1.234,5", ",5"])
def test_a_number_of_any_shape_tells_it(tmp_path, cell):
    table = read_text(tmp_path, f"a;b\n812.347;{cell}\n812.348;{cell}\n")
    assert table.columns[0].tolist() == [812347.0, 812348.0] and table.warnings == ()


def test_open_number_format_is_assumed_and_said(trace):
    recording = load(trace(header="X [ms];r4821;", rows=["0;812.347;", "2;812.348;"]))
    assert recording.output_angle_origin == pytest.approx(2 * math.pi * 812_347 / 4e6)
    [warning] = recording.warnings
    assert "812.347" in warning and "German thousands" in warning and "number_format" in warning


def test_mixed_number_formats_are_refused(trace):
    rows = ["0,0;812.347;1;0,1234;0.1234;", "2,0;812.347;1;0,1234;0.1234;"]
    refused(trace(rows=rows), "line 2", "'C5:Drive_axis_1.r76'", "'0.1234' is no number in German (1.234,5) format")
    far = [f"{i},0;812.347;1;0,1234;0,1234;" for i in range(2000)] + ["2000,0;812.347;1;0,1234;0.1234;"]
    refused(trace(rows=far), "line 2002", "'C5:Drive_axis_1.r76'", "'0.1234' is no number")


def test_a_value_that_is_not_there_is_told_as_that(trace):
    rows = [f"{i},0;812.347;1;0,1234;{'NaN' if i == 5 else '0,1'};" for i in range(20)]
    refused(trace(rows=rows), "line 7", "'C5:Drive_axis_1.r76'", "holds no value (NaN); correct it")


@given(
    st.lists(st.integers(-(10**12), 10**12), min_size=1, max_size=30),
    st.integers(0, 6),
    st.sampled_from([GERMAN, ENGLISH]),
)
@settings(deadline=None)
def test_numbers_of_any_size_survive(tmp_path_factory, whole, decimals, form):
    """What Python reads from the plain text, the fast path and the careful one read too, to the last bit."""
    exact = [number / 10**decimals for number in whole]
    english = [f"{value:,.{decimals}f}" for value in exact]
    marks = str.maketrans(",.", form.thousands + form.decimal)
    # The second column settles the format, whatever the numbers are.
    rows = [f"{text.translate(marks)};0{form.decimal}0001;" for text in english]
    values = read_text(tmp_path_factory.mktemp("numbers"), "\n".join(["a;b;", *rows, ""])).columns[0]
    plain = [float(text.replace(",", "")) for text in english]
    assert values.tolist() == plain == [form.value(text.translate(marks)) for text in english]


@pytest.mark.slow
@given(st.text(alphabet="0123456789.,+-eE", min_size=1, max_size=12))
@settings(max_examples=500, deadline=None)
def test_the_fast_path_accepts_no_more_than_the_careful_one(tmp_path_factory, cell):
    folder, text = tmp_path_factory.mktemp("cells"), f"a;b;\n{cell};0,0001;\n{cell};0,0001;\n"
    try:
        expected = GERMAN.value(cell)
    except ValueError:
        with pytest.raises(InputError):
            read_text(folder, text)
    else:
        assert read_text(folder, text, number_format="german").columns[0].tolist() == [expected, expected]


def test_other_delimiters_are_read_where_a_map_names_them(trace, tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text(SIEMENS.text.replace("number_format: auto", "number_format: english"))
    path = trace(header="X [ms];r4821;", rows=["0;812.347;", "2;812.348;"])
    recording = load(path, import_map=own)
    assert recording.output_angle_origin == pytest.approx(2 * math.pi * 812.347 / 4e6)
    assert "fractions" in recording.warnings[0]
