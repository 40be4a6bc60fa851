"""A Siemens trace as text, for tests that change it; other texts, columns and maps; and the one line of a refusal."""

import math

from ema_bench_replay.load import load
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.trace_table import read_table
from tests.one_line import refused_in_one_line

SIEMENS = load_map("siemens")
HEADER = "X [ms];C0:Drive_axis_1.r4821;C1:Drive_axis_1.r4820;C4:Drive_axis_1.r77;C5:Drive_axis_1.r76;"
ROWS = [
    "0,0;999.998;-20.480;0,1000;0,1010;",
    "2,0;1.000.001;-20.470;0,2000;0,1980;",
    "4,0;1.000.004;-20.460;0,3000;0,2970;",
    "6,0;1.000.007;-20.450;0,4000;0,4030;",
]
RPM = 2 * math.pi / 60


def read_text(folder, text, **options):
    """The table in a file of this text, str or bytes, as ``read_table`` reads it with these options."""
    path = folder / "run.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_table(path, **options)


def write_map(folder, signals, time="time: {column: t, unit: s}"):
    """Write an import map of these signals, by name in YAML, below lines such as that of the time."""
    lines = "".join(f"  {signal}: {content}\n" for signal, content in signals.items())
    path = folder / "own.yaml"
    path.write_text(f"version: 1\n{time}\nsignals:\n{lines}")
    return path


def refused(path, *words):
    with refused_in_one_line(path, *words):
        load(path)


def write_columns(place, columns, mark=",", encoding="utf-8"):
    """Write columns, (n,) each, of numbers or texts, by name."""
    rows = zip(*columns.values(), strict=True)
    cells = ([cell if isinstance(cell, str) else f"{cell:.12g}" for cell in row] for row in rows)
    place.write_text("\n".join(map(mark.join, (columns, *cells, ""))), encoding)
    return place
