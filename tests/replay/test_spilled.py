"""What grows with a recording lies on disk; and what a finished file no longer needs is let go."""

import errno
import os

import pytest

from ema_bench_replay.bags import spilled as spilled_module
from ema_bench_replay.bags.mcap_scan import McapScan
from ema_bench_replay.bags.spilled import LARGEST, Spilled
from ema_bench_replay.bags.stream_writer import StreamWriter
from tests.bags import summary_of

PIECE = bytes(range(256)) * 4
TYPE = "std_msgs/msg/String"


def fill(spilled, pieces):
    """What was added."""
    added = [bytes([k % 251]) + PIECE for k in range(pieces)]
    for piece in added:
        spilled.add(piece)
    return b"".join(added)


@pytest.mark.parametrize("pieces", [0, 1, 3 * LARGEST // len(PIECE)])
def test_is_given_back_as_it_was_added(tmp_path, pieces):
    on_disk, in_memory = Spilled(tmp_path), Spilled(None)
    added = fill(on_disk, pieces)
    assert fill(in_memory, pieces) == added
    for spilled in (on_disk, on_disk, in_memory):  # as often as it is asked for
        assert spilled.all() == added
    assert len(on_disk._kept) <= LARGEST
    added += fill(on_disk, 2)
    assert on_disk.all() == added


def test_leaves_no_file(tmp_path):
    spilled = Spilled(tmp_path)
    fill(spilled, 3 * LARGEST // len(PIECE))
    assert [*tmp_path.iterdir()] == []
    spilled.close()
    assert spilled.all() == b""


def test_what_cannot_be_written_waits_in_memory(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    spilled = Spilled(tmp_path)
    with monkeypatch.context() as patched:
        patched.setattr(spilled_module.os, "pwrite", full)
        added = fill(spilled, 3 * LARGEST // len(PIECE))
        assert spilled.all() == added
    added += fill(spilled, 2 * LARGEST // len(PIECE))
    assert spilled.all() == added
    assert len(spilled._kept) < LARGEST


def test_half_of_a_write_is_written_again(tmp_path, monkeypatch):
    """As on a disk that is full in the middle of it."""
    plain, calls = os.pwrite, []

    def half(descriptor, data, place):
        calls.append(len(data))
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        return plain(descriptor, data[: max(1, len(data) // 2)], place)

    monkeypatch.setattr(spilled_module.os, "pwrite", half)
    spilled = Spilled(tmp_path)
    added = fill(spilled, 4 * LARGEST // len(PIECE))
    assert spilled.all() == added
    assert len(spilled._kept) < 2 * LARGEST


def test_what_is_gone_from_the_disk_is_told(tmp_path):
    spilled = Spilled(tmp_path)
    fill(spilled, 2 * LARGEST // len(PIECE))
    os.ftruncate(spilled._file.fileno(), 10)
    with pytest.raises(OSError, match="gone"):
        spilled.all()


def test_a_folder_that_is_gone_is_no_place(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    spilled = Spilled(folder)
    folder.rmdir()
    added = fill(spilled, 2 * LARGEST // len(PIECE))
    assert spilled.all() == added


def test_a_recording_of_many_files_holds_what_one_needs(tmp_path):
    """A finished file keeps what was counted: with its compressor and definitions it kept 0.2 MiB."""
    folder = tmp_path / "bag"
    writer = StreamWriter(folder, max_duration=1.0)
    for topic in range(3):
        writer.add_topic(f"/t{topic}", TYPE, "")
    for second in range(20):
        for part in range(2):
            for topic in range(3):
                writer.write(f"/t{topic}", b"\0\1\0\0\1\0\0\0\0", (1_000_000_000 * second) + 600_000_000 * part)
            writer.flush()
    files = writer._files
    assert len(files) > 10
    assert [file.content._compressor is not None for file in files] == [False] * (len(files) - 1) + [True]
    assert not any(file.content._schemas or file.content._channels for file in files[:-1])
    assert sum(writer.finish().values()) == 120
    assert sum(len([*McapScan(path).messages()]) for path in folder.glob("*.mcap")) == 120


def test_the_index_of_a_long_recording_lies_on_disk_while_it_is_made(tmp_path, monkeypatch):
    """An hour at ten chunks a second has 6 MiB of it; every chunk is in the index that the file ends with."""
    monkeypatch.setattr(spilled_module, "LARGEST", 1 << 12)
    writer = StreamWriter(tmp_path / "bag")
    writer.add_topic("/t", TYPE, "")
    for chunk in range(300):
        writer.write("/t", b"\0\1\0\0\1\0\0\0\0", 100_000_000 * chunk)
        writer.flush()
        assert len(writer._files[0].content._chunks._kept) < (1 << 12) + 200
    assert [path.name for path in (tmp_path / "bag").iterdir()] == ["bag.mcap"]
    assert writer.finish() == {"/t": 300}
    assert len(summary_of(tmp_path / "bag/bag.mcap").chunk_indexes) == 300
