"""Bags that no writer makes: what random inputs found."""

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
