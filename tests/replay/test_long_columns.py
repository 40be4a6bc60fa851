"""Columns that lie on disk are what they would be in memory, and give back the memory of what was looked at."""

import errno
import os
import subprocess
import sys

import numpy as np
import pytest

from ema_bench_replay import long_columns
from ema_bench_replay.bags.bag_writer import write_bag
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.long_columns import (
    Column,
    by_pieces,
    extremes,
    joined,
    mean_of,
    median,
    overlapping,
    pieces,
    quantile,
    slopes,
    spread_pieces,
    values_at,
)
from ema_bench_replay.recording import Recording

RANDOM = np.random.default_rng(7)
VALUES = RANDOM.normal(size=30_011)
DRAWS = {
    "normal": VALUES,
    "few levels": np.repeat(RANDOM.normal(size=30), 1000),
    "all alike": np.zeros(5000),
    "nearly all alike": np.concatenate([np.zeros(4000), [1.0, 2.0, 3.0]]),
    "rising": np.arange(5000.0),
    "two levels, half each": np.repeat([2e6, 2e6 + 1.0], 3000),
    "slow": np.sin(np.arange(40_000) / 5000.0),
    "periodic": np.tile([1.0, 0.0, 2.0, 3.0], 5000),  # every 64th value is the same
    "infinite at its ends": np.concatenate([[-np.inf] * 9, VALUES, [np.inf] * 9]),
}


@pytest.fixture
def short(monkeypatch):
    """Recordings are long from 1001 samples on."""
    monkeypatch.setattr(long_columns, "WHOLE", 1000)
    monkeypatch.setattr(long_columns, "PIECE", 300)


def on_disk(values):
    column = Column(values.dtype)
    for first in range(0, len(values), 700):
        column.add(values[first : first + 700])
    return column.finish()


def test_pieces_follow_each_other_and_none_is_short(short):
    assert list(pieces(1000)) == [slice(0, 1000)]
    for count in (1001, 1199, 1200, 1349, 1350, 4321):
        found = list(pieces(count, 7))
        assert [part.start for part in found] == [0, *(part.stop for part in found[:-1])]
        assert found[-1].stop == count
        assert all((part.stop - part.start) % 7 == 0 for part in found[:-1])
        assert min(part.stop - part.start for part in found) >= 140
    assert sum(part.stop - part.start for part in spread_pieces(100_000)) < 1200
    assert spread_pieces(800) == [slice(0, 800)]


def test_a_column_holds_on_disk_what_it_would_in_memory(short):
    for values in (VALUES, np.arange(5000), VALUES > 0.0):
        column = on_disk(values)
        assert column.dtype == values.dtype
        np.testing.assert_array_equal(column, values)
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 1
        long_columns.release_pages()
        np.testing.assert_array_equal(column[::-7], values[::-7])
    assert on_disk(VALUES[:1000]).flags.writeable  # no longer than what lies in memory


@pytest.mark.parametrize("values", DRAWS.values(), ids=DRAWS)
@pytest.mark.parametrize("share", [0.0, 0.001, 0.25, 0.5, 0.9, 0.995, 1.0])
def test_quantiles_are_those_of_the_whole(values, share, short):
    def parts():
        return (values[rows] for rows in pieces(len(values)))

    if np.isfinite(values).all():
        assert quantile(parts, share) == np.quantile(values, share)
    elif 0.0 < share < 1.0:
        assert quantile(parts, share) == pytest.approx(np.quantile(values, share), rel=1e-12)
    assert median(parts) == np.median(values)


def test_a_draw_that_tells_nothing_does_no_harm(short, monkeypatch):
    values = DRAWS["periodic"]
    for level in (0.0, 1.0, 2.0, 3.0, 1.5, -7.0):
        monkeypatch.setattr(long_columns, "_draw", lambda parts, level=level: np.full(300, level))
        for share in (0.1, 0.25, 0.499, 0.5, 0.75, 0.9):
            assert quantile(lambda: (values[rows] for rows in pieces(len(values))), share) == np.quantile(values, share)
        assert median(lambda: (values[rows] for rows in pieces(len(values)))) == 1.5


def test_the_draw_is_the_same_each_time_and_one_a_block(short):
    parts = [np.arange(1000), np.arange(1000, 1030), np.arange(0)]
    drawn = long_columns._draw(parts)
    np.testing.assert_array_equal(long_columns._draw(parts), drawn)
    assert (drawn[:15] // 64).tolist() == list(range(15))
    assert len(drawn) == 17
    assert len(set(drawn[:15] % 64)) > 7  # at no fixed place in the blocks


def test_what_is_worked_out_by_pieces_is_what_the_whole_gives(short):
    column, time = on_disk(VALUES), np.cumsum(1.0 + RANDOM.random(len(VALUES)))
    np.testing.assert_array_equal(by_pieces(np.square, column), VALUES**2)
    np.testing.assert_array_equal(by_pieces(lambda a, b: a[b > 0.0], column, column), VALUES[VALUES > 0.0])
    np.testing.assert_array_equal(joined([column, VALUES[:5]]), np.concatenate([VALUES, VALUES[:5]]))
    np.testing.assert_allclose(slopes(column, time), np.gradient(VALUES, time), rtol=1e-12)
    np.testing.assert_array_equal(np.concatenate([np.diff(part) for part in overlapping(column)]), np.diff(VALUES))
    places = RANDOM.permutation(len(VALUES))[:500]
    np.testing.assert_array_equal(values_at(column, places), VALUES[places])
    assert mean_of(column) == pytest.approx(VALUES.mean(), rel=1e-12)
    assert extremes(column) == (VALUES.min(), VALUES.max())
    assert extremes(np.array([np.nan, 2.0, 1.0])) == (1.0, 2.0)
    for unknown in (np.full(3, np.nan), np.zeros(0), np.zeros(0, np.int64)):
        assert np.isnan(extremes(unknown)).all()
        with np.errstate(all="raise"):
            assert np.isnan(mean_of(unknown))
    assert np.isnan(median(lambda: []))


def test_a_disk_without_room_is_told(short, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(InputError, match=r"No space left on device.*TMPDIR"):
        on_disk(VALUES)


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ENFILE])
@pytest.mark.parametrize("opens", ["tempfile.TemporaryFile", "mmap.mmap"])
def test_too_many_open_files_are_told_with_what_helps(number, opens, short, monkeypatch):
    def refuse(*_, **__):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(f"ema_bench_replay.long_columns.{opens}", refuse)
    with pytest.raises(InputError, match=r"open files.*fewer recordings.*ulimit -n") as caught:
        on_disk(VALUES)
    assert "TMPDIR" not in str(caught.value)


MANY_COLUMNS = """
import resource, sys
import numpy as np
from ema_bench_replay import long_columns
from ema_bench_replay.errors import InputError
long_columns.WHOLE, long_columns.PIECE = 1000, 300
resource.setrlimit(resource.RLIMIT_NOFILE, (40, int(sys.argv[1])))
columns = []
try:
    for k in range(60):
        column = long_columns.Column(float)
        column.add(np.full(1001, float(k)))
        columns.append(column.finish())
except InputError as error:
    print(error)
else:
    print(sum(column[-1] for column in columns))
"""


def test_as_many_files_are_opened_as_the_process_may():
    """Each column on disk is an open file: the usual limit would be reached at some 50 long recordings."""

    def told(limit):
        run = subprocess.run(
            [sys.executable, "-c", MANY_COLUMNS, str(limit)], capture_output=True, text=True, check=True
        )
        return run.stdout.strip()

    assert told(200) == "1770.0"
    assert "this process may have 40 (Too many open files)" in told(40)


def test_a_long_recording_is_read_as_a_short_one(tmp_path, monkeypatch):
    count = 4000
    stamps = np.cumsum(np.where(np.arange(count) % 1000 == 500, 9_000_000, 2_000_000)) - 2_000_000
    signals = {
        "current": RANDOM.normal(size=count),
        "motor_position": 3.0 + RANDOM.normal(size=count),
        "output_position": RANDOM.normal(size=count),
        "output_command": RANDOM.normal(size=count),
    }
    bag = write_bag(Recording("run", stamps, signals, motor_angle_origin=0.5), tmp_path)
    whole = load(bag)
    monkeypatch.setattr(long_columns, "WHOLE", 1000)
    monkeypatch.setattr(long_columns, "PIECE", 300)
    shares = []
    long = load(bag, progress=shares.append)
    assert shares == sorted(shares)
    assert 0.0 < shares[0] < 0.5 < shares[-1] <= 1.0
    assert not any(values.flags.writeable for values in long.signals.values())
    for one, other in ((whole, long), (whole.between(0.1, 7.0), long.between(0.1, 7.0))):
        assert (one.sample_period, one.gaps, one.start) == (other.sample_period, other.gaps, other.start)
        assert one.motor_angle_origin == other.motor_angle_origin
        assert one.output_angle_origin == other.output_angle_origin
        np.testing.assert_array_equal(one.time, other.time)
        assert one.signals.keys() == other.signals.keys()
        for name, values in one.signals.items():
            np.testing.assert_array_equal(values, other.signals[name])


def test_parts_of_a_long_recording_are_cut_as_between_cuts_them(short):
    stamps = np.arange(4000) * 2_000_000
    recording = Recording("run", stamps, {"motor_position": np.arange(4000.0)}, motor_angle_origin=1.0)
    parts = list(recording.parts())
    assert sum(map(len, parts)) == 4000
    second = recording.between(parts[0].duration + 0.001, parts[0].duration + parts[1].duration + 0.003)
    assert (len(parts[1]), parts[1].motor_angle_origin) == (len(second), second.motor_angle_origin)
    np.testing.assert_array_equal(parts[1].signals["motor_position"], second.signals["motor_position"])
    assert sum(map(len, recording.spread())) < 1200
    brief = recording.between(0.0, 1.0)
    assert (*brief.parts(), *brief.spread()) == (brief, brief)
