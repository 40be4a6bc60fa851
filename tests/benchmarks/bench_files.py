"""Files: how fast traces are imported, how soon six recordings are compared, what half an hour costs in memory.

Times stand beside those of Python and of numba alone, taken in the same run: machines differ, and are noisy.
"""

import csv
import subprocess
import sys
import time
from dataclasses import replace

import pytest

from ema_bench_replay.bags.bag_writer import write_bag, write_mcap
from ema_bench_replay.load import load
from ema_bench_replay.traces.import_map import load_map
from ema_bench_replay.traces.trace_csv import read_trace
from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.benchmarks.timing import fastest
from tests.command_line import TWIN
from tests.conftest import RECORDINGS

TRACES = sorted(RECORDINGS.glob("*.CSV"))
ROUNDS = 5
MOST_TO_IMPORT, MOST_TO_COMPARE = 1.5, 5.0
"""Times what Python, and the import of numba, take."""


OBSERVER = """
import resource, subprocess, sys, time
begin = time.perf_counter()
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0)
"""
"""A small process that starts the measured one: a child's peak begins with the memory of who starts it."""


def measured(*command):
    """(wall seconds, peak MiB) of one process."""
    told = subprocess.run([sys.executable, "-c", OBSERVER, *map(str, command)], capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    return tuple(map(float, told.stdout.split()))


def test_import(tmp_path, say):
    siemens = load_map("siemens")
    size = sum(path.stat().st_size for path in TRACES)

    def imported():
        for path in TRACES:
            write_bag(read_trace(path, siemens), tmp_path, force=True)

    def merely_read():
        for path in TRACES:
            with path.open(encoding="latin-1") as file:
                next(file)
                for row in csv.reader(file, delimiter=";"):
                    [float(cell.replace(".", "").replace(",", ".")) for cell in row if cell]

    best, plain = fastest(ROUNDS, imported, merely_read)
    rate = size / best / 1e6
    say(f"\n  import: {rate:.1f} MB of CSV a second of processor time, files of {size / len(TRACES) / 1e6:.2f} MB")
    say(f"    {best / plain:.2f} × the time that Python's csv and float take")
    assert best <= MOST_TO_IMPORT * plain


def test_bags_are_read(tmp_path, say):
    """Six recordings of 20 s are to be read in 0.15 s."""
    siemens = load_map("siemens")
    folders = [write_bag(read_trace(path, siemens), tmp_path) for path in TRACES]
    best = float("inf")
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for folder in folders:
            load(folder)
        best = min(best, time.perf_counter() - begin)
    say(f"\n  {len(folders)} bags of 20 s read in {best:.3f} s")
    assert best <= 2 * 0.15 * len(folders) / 6


def test_compare_six_recordings(tmp_path, say):
    siemens = load_map("siemens")
    for k in range(6):
        recording = read_trace(TRACES[k % len(TRACES)], siemens)
        write_bag(replace(recording, name=f"run_{k}"), tmp_path)
    runs = sorted(tmp_path.iterdir())
    command = (TWIN, "compare", *runs, "--model", "polito_bench")
    measured(*command)
    both = [(measured(*command), measured(sys.executable, "-c", "import numba")) for _ in range(ROUNDS)]
    (seconds, peak), (start, _) = map(min, zip(*both, strict=True))
    say(f"\n  compare, six recordings of 20 s, process start included: {seconds:.2f} s, {peak:.0f} MiB")
    say(f"    {seconds / start:.1f} × the time in which Python imports numba")
    assert seconds <= MOST_TO_COMPARE * start


@pytest.mark.parametrize("source", ["setpoint", "current"])
def test_memory_of_half_an_hour(tmp_path, say, source):
    bench = virtual_bench(load_model("polito_bench"), parse_command("triangle:0.04:5"), 1800.0)
    run = tmp_path / "half_an_hour.mcap"
    write_mcap(bench, run)
    seconds, peak = measured(TWIN, "compare", run, "--model", "polito_bench", "--input", source)
    say(f"\n  compare, driven by the {source}, 30 minutes ({len(bench)} samples): {seconds:.1f} s, peak {peak:.0f} MiB")
    assert peak <= 500.0
