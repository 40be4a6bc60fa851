"""The MCAP project's 416 conformance files are read as they are, and refused in one line as recordings of no bench."""

import hashlib
from pathlib import Path

import pytest
from mcap.records import Channel, Message, Metadata, Schema

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.bags.mcap_scan import McapScan
from ema_bench_replay.bags.recover import recover
from ema_bench_replay.errors import InputError
from tests.mcap_conformance import CONTENTS, conformance_file

LIST = dict(line.split() for line in Path(__file__).with_name("mcap_conformance.txt").read_text().splitlines())
"""Names of the files, and how the SHA-256 of each begins (github.com/foxglove/mcap, tests/conformance/data)."""


@pytest.mark.parametrize("content", CONTENTS)
def test_each_file_is_read_as_it_is(content, tmp_path):
    names = [name for name in LIST if name.partition("-")[0] == content]
    path, whole = tmp_path / "file.mcap", tmp_path / "whole.mcap"
    messages = [(m.log_time, m.publish_time, m.sequence, m.data) for m in of_kind(content, Message)]
    assert names
    for name in names:
        data = conformance_file(name)
        assert hashlib.sha256(data).hexdigest().startswith(LIST[name]), name  # it is the reference file, bit for bit
        path.write_bytes(data)
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


def of_kind(content, kind):
    return [record for record in CONTENTS[content] if isinstance(record, kind)]
