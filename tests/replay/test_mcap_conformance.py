"""The MCAP project's 416 conformance files are read as they are, and refused in one line as recordings of no bench."""

import hashlib

import pytest
from mcap.records import Channel, Message, Metadata, Schema

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.bags.mcap_scan import McapScan
from ema_bench_replay.bags.recover import recover
from ema_bench_replay.errors import InputError
from tests.mcap_conformance import CONTENTS, conformance_file, conformance_names

FILES = {
    "NoData": (6, "4616ecf03e9e4b29"),
    "OneAttachment": (14, "df3ff8e139480f86"),
    "OneMessage": (154, "f535432e74561ef1"),
    "OneMetadata": (14, "b59d1fb36ccb8fac"),
    "OneSchemalessMessage": (74, "5a306136f41144b6"),
    "TenMessages": (154, "f1624930f62d99c3"),
}
"""How many files of each content there are (github.com/foxglove/mcap, tests/conformance/data), and how the SHA-256 of
all of them begins: ``LC_ALL=C; cat CONTENT*.mcap | sha256sum``."""


@pytest.mark.parametrize("content", FILES)
def test_each_file_is_read_as_it_is(content, tmp_path):
    names = sorted(conformance_names(content), key="{}.mcap".format)
    all_bytes = hashlib.sha256()
    path, whole = tmp_path / "file.mcap", tmp_path / "whole.mcap"
    messages = [(m.log_time, m.publish_time, m.sequence, m.data) for m in of_kind(content, Message)]
    for name in names:
        path.write_bytes(conformance_file(name))
        all_bytes.update(path.read_bytes())
        scan = McapScan(path)
        found = [(m.log_time, m.publish_time, m.sequence, m.data) for m in scan.messages()]
        assert found == messages and scan.damage is None and scan.torn == 0, name
        assert list(scan.channels.values()) == of_kind(content, Channel), name
        assert list(scan.schemas.values()) == of_kind(content, Schema), name
        assert scan.metadata == of_kind(content, Metadata), name
        with pytest.raises(InputError) as caught:  # it is of no bench
            read_bag(path)
        assert str(path) in str(caught.value) and "; " in str(caught.value), name
        if messages:
            assert recover(path, whole, force=True).messages == {"example": len(messages)}, name
    # they are the reference files, bit for bit
    assert (len(names), all_bytes.hexdigest()[:16]) == FILES[content]


def of_kind(content, kind):
    return [record for record in CONTENTS[content] if isinstance(record, kind)]
