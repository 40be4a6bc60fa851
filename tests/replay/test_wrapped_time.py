"""A clock that begins again after a round span is counted on; a new run in the same file is told from it."""

import numpy as np
import pytest

from ema_bench_replay import long_columns
from ema_bench_replay.errors import TimeGoesBackError
from ema_bench_replay.load import load
from tests.trace_text import write_columns, write_map

STEPS = 2.1 + 0.05 * np.random.default_rng(4).standard_normal(2000)  # ms, of a loop that nothing clocks
TIME = 0.076 + np.cumsum(STEPS)


@pytest.fixture
def read(tmp_path):
    def read(time, unit="ms"):
        clock = f"time: {{column: time, unit: {unit}}}"
        own = write_map(tmp_path, {"current": "{columns: [current], unit: A}"}, clock)
        file = write_columns(tmp_path / "run.csv", {"time": time, "current": np.sin(np.arange(len(time)))})
        return load(file, import_map=own)

    return read


def wraps(recording):
    return [warning for warning in recording.warnings if "begins again" in warning]


def test_the_milliseconds_of_a_second_are_counted_on(read):
    recording = read(TIME % 1000.0)
    assert recording.time == pytest.approx((TIME - TIME[0]) * 1e-3, abs=1e-8)
    (told,) = wraps(recording)
    line = 2 + int(np.flatnonzero(np.diff(TIME % 1000.0) < 0)[0]) + 1
    assert told.startswith("run.csv: column 'time': time begins again after 1000 ms, 4 times, first in ")
    assert f"line {line}: repaired, counted on" in told


@pytest.mark.parametrize(
    ("unit", "step", "span"),
    [("us", 250, 1 << 16), ("ms", 1, 1 << 16), ("us", 9_000_000, 1 << 32), ("s", 2e-3, 65.536), ("s", 0.05, 60.0),
     ("s", 60.0 * 7.1, 86400.0)],
)  # fmt: skip
def test_counters_and_clocks_of_any_span(read, unit, step, span):
    time = span + step * (np.arange(2000) - 700.37)
    time = np.rint(time) if unit != "s" else time
    seconds = {"s": 1.0, "ms": 1e-3, "us": 1e-6}[unit]
    recording = read(time % span, unit)
    assert recording.time == pytest.approx((time - time[0]) * seconds, rel=1e-9, abs=1e-8)
    assert len(wraps(recording)) == 1


def test_a_clock_that_comes_back_to_its_first_value_by_chance_is_counted_on(read):
    time = TIME[:900].copy()
    fall = int(np.flatnonzero(np.diff(time % 1000.0) < 0)[0]) + 1
    time[fall] = 1000.0 + time[0]
    assert len(wraps(read(time % 1000.0))) == 1


def test_a_long_recording_too(read, monkeypatch):
    monkeypatch.setattr(long_columns, "WHOLE", 500)
    monkeypatch.setattr(long_columns, "PIECE", 300)
    assert read(TIME % 1000.0).time == pytest.approx((TIME - TIME[0]) * 1e-3, abs=1e-8)


@pytest.mark.parametrize(
    ("time", "unit"),
    [
        (np.tile(np.arange(0.0, 1000.0, 2.0), 3), "ms"),  # of a second each, which all begin at zero
        (np.tile(np.arange(2.0, 1001.0, 2.0), 3), "ms"),  # or with their first step
        (np.tile(TIME[:476] - TIME[0], 2), "ms"),  # or at zero, by a clock that goes unevenly
        (np.concatenate([TIME[:470], TIME[:300]]), "ms"),  # the second begins before the span has passed
        (np.concatenate([TIME[:400], TIME]), "ms"),
        (np.concatenate([(TIME % 1000.0)[:900], TIME[:300]]), "ms"),  # one fall is none of a counter
        (np.tile(np.arange(0.0, 7.0, 0.01), 2), "s"),
    ],
)
def test_runs_one_below_the_other_are_refused(read, time, unit):
    with pytest.raises(TimeGoesBackError, match="it holds more than one run"):
        read(time, unit)
