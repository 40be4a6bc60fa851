"""Bags that no writer makes: what random inputs found."""

import struct

import pytest
from mcap.writer import CompressionType

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.bags.mcap_scan import McapScan
from tests.bags import some_samples, write_other
from tests.fuzz.mutations import MAGIC, joined, records_of

MESSAGE = 5


def test_a_message_that_is_shorter_than_its_own_head_is_damage(tmp_path):
    path = write_other(tmp_path / "run.mcap", some_samples(), chunked=False)
    records = records_of(path.read_bytes()[len(MAGIC) :])
    last = max(place for place, (opcode, _) in enumerate(records) if opcode == MESSAGE)
    records[last] = MESSAGE, records[last][1][:20]
    path.write_bytes(MAGIC + joined(records) + MAGIC)
    scan = McapScan(path)
    assert len(list(scan.messages())) == len(some_samples()) - 1
    assert scan.damage == "a record is damaged"
    assert len(read_bag(path)) == len(some_samples()) - 1


@pytest.mark.parametrize("compression", [CompressionType.LZ4, CompressionType.ZSTD])
def test_a_summary_that_begins_at_the_chunks_unpacks_none(compression, tmp_path, monkeypatch):
    """The library would unpack them without bounds, and raise what it does not tell of."""
    path = write_other(tmp_path / "run.mcap", some_samples(), compression=compression)
    data = bytearray(path.read_bytes())
    struct.pack_into("<Q", data, len(data) - len(MAGIC) - 20, len(MAGIC))  # the footer's summary_start
    path.write_bytes(data)
    monkeypatch.setattr("mcap.stream_reader.breakup_chunk", lambda *_, **__: pytest.fail("the library unpacks"))
    assert len(read_bag(path)) == len(some_samples())
