"""A recording whose disk is full, or whose file or folder goes away: that is told, counted and gone on with."""

import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader

from ema_bench_replay.bags import bag_file, stream_writer
from ema_bench_replay.bags.bag_metadata import STATE_QOS
from ema_bench_replay.bags.mcap_file import MAGIC
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.load import load
from ema_bench_replay.recording import NO_DATE
from tests.bags import STATE, listed_in, serialised, summary_of
from tests.namespaces import on_own_disk

FOLDER = Path(__file__).resolve().parents[2]
TOPIC = "/bench/state"


class Bench:
    """Publishes samples to a writer, 1 kHz in their own time."""

    def __init__(self, writer):
        self.writer = writer
        self.step = 1_000_000
        self.sent = 0
        writer.add_topic(TOPIC, STATE, STATE_QOS)

    def send(self, count):
        stamps = {number: NO_DATE + number * self.step for number in range(self.sent, self.sent + count)}
        samples = [({"stamp": t, "sequence": k, "current": float(k % 97)}, t) for k, t in stamps.items()]
        for message, logged in serialised(samples):
            self.writer.write(TOPIC, message, logged)
        self.sent += count
        self.writer.flush()


class Disk:
    """Takes the place of the system's writing: what it has room for is written, then it is full."""

    def __init__(self, monkeypatch):
        self.room = 1 << 40
        self.error = errno.ENOSPC
        self.once = False
        self._write = os.pwrite
        monkeypatch.setattr(bag_file.os, "pwrite", self.write)

    def write(self, descriptor, data, offset):
        if not self.room:
            self.room = 1 << 40 if self.once else 0
            raise OSError(self.error, os.strerror(self.error))
        done = self._write(descriptor, data[: self.room], offset)
        self.room -= done
        return done


@pytest.fixture
def disk(monkeypatch):
    return Disk(monkeypatch)


@pytest.fixture
def bench(tmp_path, monkeypatch):
    monkeypatch.setattr(stream_writer, "PATIENCE", 0)
    return Bench(StreamWriter(tmp_path / "live"))


def whole(path):
    return summary_of(path).statistics.message_count


def opened_by_others(folder):
    with AnyReader([folder]) as reader:
        return sum(1 for _ in reader.messages())


class TestFullDisk:
    def test_nothing_is_lost_where_room_comes_again(self, bench, disk, tmp_path):
        bench.send(1000)
        disk.room = 500  # half a chunk fits
        bench.send(1000)
        assert "No space left on device" in bench.writer.problem and "make room" in bench.writer.problem
        assert bench.writer.written == {TOPIC: 1000} and bench.writer.waiting == 1000
        assert whole_so_far(bench.writer.path) == 1000  # what did not fit is taken back
        disk.room = 1 << 40
        bench.send(1000)
        assert not bench.writer.problem and not bench.writer.waiting
        assert bench.writer.finish() == {TOPIC: 3000} and bench.writer.lost == {TOPIC: 0}
        recording = load(tmp_path / "live")
        assert len(recording) == 3000 and not recording.warnings
        assert whole(tmp_path / "live" / "live.mcap") == opened_by_others(tmp_path / "live") == 3000

    def test_what_finds_no_room_in_memory_either_is_counted(self, bench, disk, tmp_path, monkeypatch):
        monkeypatch.setattr(stream_writer, "LARGEST_WAITING", 50_000)
        bench.send(500)
        disk.room = 0
        bench.send(1500)
        lost, waiting = bench.writer.lost[TOPIC], bench.writer.waiting
        assert lost > 500 and lost + waiting == 1500
        disk.room = 1 << 40
        bench.send(500)
        assert bench.writer.finish() == {TOPIC: 2500 - lost} and bench.writer.lost == {TOPIC: lost}
        assert load(tmp_path / "live").warnings == (f"live.mcap: /bench/state: {lost} samples are missing",)

    def test_one_that_is_full_to_the_end_loses_what_waits(self, bench, disk, tmp_path):
        bench.send(1000)
        disk.room = 0
        bench.send(1000)
        assert bench.writer.finish() == {TOPIC: 1000}
        assert bench.writer.lost == {TOPIC: 1000}
        assert bench.writer.unfinished == [tmp_path / "live" / "live.mcap"]
        assert len(load(tmp_path / "live")) == 1000

    def test_another_error_goes_on_in_a_new_file(self, bench, disk, tmp_path):
        bench.send(1000)
        disk.room, disk.error = 0, errno.EIO
        bench.send(500)
        assert "Input/output error" in bench.writer.problem
        assert len(list((tmp_path / "live").iterdir())) == 1  # no attempt leaves an empty file
        disk.room = 1 << 40
        bench.send(500)
        assert bench.writer.finish() == {TOPIC: 2000} and bench.writer.lost == {TOPIC: 0}
        assert [file.name for file in bench.writer.files] == ["live.mcap", "live_1.mcap"]
        recording = load(tmp_path / "live")
        assert len(recording) == 2000
        assert recording.warnings == ("live.mcap: the file is cut, so only what is before that can be used",)
        assert opened_by_others(tmp_path / "live") == 1000  # the whole file alone is listed

    def test_a_file_that_failed_is_finished_where_it_can_be(self, bench, disk, tmp_path, monkeypatch):
        """The index is shorter than what was written of the chunk that failed, and stands in its place."""
        monkeypatch.setattr(stream_writer, "LONGEST_CHUNK", 10**12)
        bench.step = 10_000
        bench.send(2000)
        disk.room, disk.error, disk.once = 40_000, errno.EIO, True
        bench.send(6000)
        bench.send(1000)
        assert bench.writer.finish() == {TOPIC: 9000}
        assert [file.name for file in bench.writer.files] == ["live.mcap", "live_1.mcap"]
        assert not bench.writer.unfinished
        assert bench.writer.files[0].read_bytes().endswith(MAGIC)
        assert opened_by_others(tmp_path / "live") == 9000 and not load(tmp_path / "live").warnings

    @pytest.mark.slow
    def test_a_disk_of_a_few_kilobytes(self, tmp_path):
        """A file system of its own, in a namespace where the user may mount one."""
        room = tmp_path / "disk"
        room.mkdir()
        script = f"""
import os, sys
from pathlib import Path
sys.path.insert(0, {str(FOLDER)!r})
from tests.nodes.test_recorder_faults import *
stream_writer.PATIENCE = 0
room = Path({str(room)!r})
other = room / "other"
other.write_bytes(bytes(200_000))
bench = Bench(StreamWriter(room / "live"))
bench.send(500)
while not bench.writer.problem and bench.sent < 100_000:
    bench.send(500)
assert "No space left" in bench.writer.problem, bench.writer.problem
bench.send(1000)
other.unlink()
bench.send(500)
assert not bench.writer.problem and bench.writer.finish() == {{TOPIC: bench.sent}}
assert len(load(room / "live")) == opened_by_others(room / "live") == bench.sent
"""
        command = on_own_disk(room, "400k", 'exec "$0" -c "$1"')
        done = subprocess.run([*command, sys.executable, script], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


class TestRemoved:
    @pytest.mark.parametrize("what", ["file", "folder"])
    def test_it_is_counted_and_gone_on_with(self, bench, tmp_path, what):
        """What is written to a removed file goes on without an error of the system's, and is nowhere."""
        bench.send(1000)
        shutil.rmtree(tmp_path / "live") if what == "folder" else bench.writer.path.unlink()
        assert bench.writer.written == {TOPIC: 0} and bench.writer.lost == {TOPIC: 1000}
        bench.send(700)
        assert bench.writer.path == tmp_path / "live" / "live_1.mcap"
        assert bench.writer.finish() == {TOPIC: 700} and bench.writer.lost == {TOPIC: 1000}
        assert [(file.path.name, file.messages) for file in bench.writer.removed] == [("live.mcap", 1000)]
        recording = load(tmp_path / "live")
        assert len(recording) == opened_by_others(tmp_path / "live") == 700
        assert recording.warnings == (
            f"live_1.mcap: {TOPIC}: begins with sample 1000 of its run: the recorder came late",
        )

    def test_no_folder_is_made_where_the_disk_was(self, tmp_path, monkeypatch):
        monkeypatch.setattr(stream_writer, "PATIENCE", 0)
        disk = tmp_path / "disk"
        bench = Bench(StreamWriter(disk / "live"))
        bench.send(1000)
        disk.rename(tmp_path / "unplugged")
        bench.send(500)
        assert "No such file or directory" in bench.writer.problem and not disk.exists()
        assert bench.writer.waiting == 500
        disk.mkdir()
        bench.send(500)
        assert not bench.writer.problem
        assert bench.writer.finish() == {TOPIC: 1000} and bench.writer.lost == {TOPIC: 1000}
        assert len(load(disk / "live")) == 1000
        assert whole(tmp_path / "unplugged" / "live" / "live.mcap") == 1000  # it was moved, and is finished there

    def test_one_that_is_removed_after_its_last_message(self, bench):
        bench.send(1000)
        bench.writer.path.unlink()
        assert bench.writer.finish() == {TOPIC: 0} and bench.writer.lost == {TOPIC: 1000}

    def test_an_earlier_part_that_is_removed(self, tmp_path):
        bench = Bench(StreamWriter(tmp_path / "live", max_duration=1.0))
        bench.send(3000)
        (tmp_path / "live" / "live_1.mcap").unlink()
        counts = bench.writer.finish()
        assert counts[TOPIC] + bench.writer.lost[TOPIC] == 3000 and 900 <= bench.writer.lost[TOPIC] <= 1000
        assert "live_1.mcap" not in listed_in(tmp_path / "live")["relative_file_paths"]
        assert len(load(tmp_path / "live")) == opened_by_others(tmp_path / "live") == counts[TOPIC]


def whole_so_far(path):
    """Messages that a file has before its end is written."""
    from ema_bench_replay.bags.mcap_scan import McapScan

    return sum(1 for _ in McapScan(path).messages())
