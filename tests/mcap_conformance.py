"""The MCAP project's conformance files: every combination of features, made here as its own generator makes them."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from itertools import combinations

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from ema_bench_replay.bags.mcap_file import MAGIC, bytes_of

_DATA = b"\x01\x02\x03"
_EXAMPLE = [Schema(1, b"\x04\x05\x06", "c", "Example"), Channel(1, "example", "a", {"foo": "bar"}, 1)]
_LOGGED = (0, 2, 1, 3, 3, 5, 4, 7, 8, 9)
CONTENTS: dict[str, list[McapRecord]] = {
    "NoData": [],
    "OneAttachment": [Attachment(1, 2, "myFile", "application/octet-stream", _DATA)],
    "OneMessage": [*_EXAMPLE, Message(1, 2, _DATA, 1, 10)],
    "OneMetadata": [Metadata("myMetadata", {"foo": "bar"})],
    "OneSchemalessMessage": [Channel(1, "example", "text", {}, 0), Message(1, 2, _DATA, 1, 10)],
    "TenMessages": [*_EXAMPLE, *(Message(1, time, _DATA, time, k) for k, time in enumerate(_LOGGED))],
}
"""Records by the names that the files begin with."""
_NEVER_PADDED = (Opcode.MESSAGE, Opcode.CHUNK, Opcode.DATA_END, Opcode.FOOTER)
_PADDING = b"\x01\xff\xff"
_FEATURE_OF = {Schema: "rsh", Channel: "rch", Attachment: "ax", Metadata: "mdx"}
"""The feature that puts a kind of record, or its index, into the summary."""


def conformance_names(content: str) -> Iterator[str]:
    """The names of all files of that content."""
    kinds = {type(record) for record in CONTENTS[content]}
    in_summary = {"st", *(feature for kind, feature in _FEATURE_OF.items() if kind in kinds)}
    of_chunks = {"ch", "chx", "mx"} if Message in kinds else set()
    features = sorted(in_summary | of_chunks | {"pad", "sum"})
    for count in range(len(features) + 1):
        for chosen in combinations(features, count):
            indexes_chunks, gives_offsets = not {"chx", "mx"}.isdisjoint(chosen), "sum" in chosen
            has_groups = not (in_summary | {"chx"}).isdisjoint(chosen)
            if ("ch" in chosen or not indexes_chunks) and (has_groups or not gives_offsets):
                yield "-".join((content, *chosen))


def conformance_file(name: str) -> bytes:
    """The file of that name: its content, then its features, for instance ``OneMessage-ch-mx``.

    ch: a chunk, mx: its message index, chx: an index of chunks, ax: of attachments, mdx: of metadata, rsh: schemas and
    rch: channels again in the summary, st: statistics, sum: summary offsets, pad: bytes behind what a record needs.
    """
    content, *features = name.split("-")
    return _File(CONTENTS[content], frozenset(features)).data


class _File:
    def __init__(self, records: list[McapRecord], features: frozenset[str]) -> None:
        self.records, self.features = records, features
        self.data = MAGIC
        self.indices: dict[str, list[McapRecord]] = {"mdx": [], "ax": [], "chx": []}
        self.write(Header("", ""))
        self.write_records()
        self.write(DataEnd(zlib.crc32(self.data)))
        self.write_summary()

    def write(self, record: McapRecord) -> int:
        """Append a record; returns its length."""
        data = bytes_of(record)
        if "pad" in self.features and data[0] not in _NEVER_PADDED:
            content = data[9:] + _PADDING
            data = data[:1] + len(content).to_bytes(8, "little") + content
        self.data += data
        return len(data)

    def of_kind(self, *kinds: type) -> list[McapRecord]:
        return [record for record in self.records if isinstance(record, kinds)]

    def write_records(self) -> None:
        chunked = self.of_kind(Schema, Channel, Message) if "ch" in self.features else []
        for record in self.records:
            if record in chunked:
                continue
            offset = len(self.data)
            length = self.write(record)
            if isinstance(record, Attachment):
                times = record.log_time, record.create_time
                self.indices["ax"].append(
                    AttachmentIndex(offset, length, *times, len(record.data), record.name, record.media_type)
                )
            elif isinstance(record, Metadata):
                self.indices["mdx"].append(MetadataIndex(offset, length, record.name))
        if "ch" in self.features:
            self.write_chunk(chunked)

    def write_chunk(self, records: Iterable[McapRecord]) -> None:
        data, entries, times = b"", [], []
        for record in records:
            if isinstance(record, Message):
                entries.append((record.log_time, len(data)))
                times.append(record.log_time)
            data += bytes_of(record)
        start = len(self.data)
        length = self.write(Chunk("", data, max(times), min(times), zlib.crc32(data), len(data)))
        offsets, index_start = {}, len(self.data)
        if "mx" in self.features:
            offsets[1] = index_start
            self.write(MessageIndex(1, entries))
        sizes = len(self.data) - index_start, offsets, min(times), len(data)
        self.indices["chx"].append(ChunkIndex(length, start, "", len(data), max(times), *sizes))

    def write_summary(self) -> None:
        start = len(self.data)
        messages = [record for record in self.records if isinstance(record, Message)]
        times = [message.log_time for message in messages] or [0]
        statistics = Statistics(
            attachment_count=len(self.of_kind(Attachment)),
            channel_count=len(self.of_kind(Channel)),
            channel_message_counts={1: len(messages)} if messages else {},
            chunk_count=int("ch" in self.features),
            message_count=len(messages),
            message_end_time=max(times),
            message_start_time=min(times),
            metadata_count=len(self.of_kind(Metadata)),
            schema_count=len(self.of_kind(Schema)),
        )
        groups = [
            ("rsh", Opcode.SCHEMA, self.of_kind(Schema)),
            ("rch", Opcode.CHANNEL, self.of_kind(Channel)),
            ("st", Opcode.STATISTICS, [statistics]),
            ("mdx", Opcode.METADATA_INDEX, self.indices["mdx"]),
            ("ax", Opcode.ATTACHMENT_INDEX, self.indices["ax"]),
            ("chx", Opcode.CHUNK_INDEX, self.indices["chx"]),
        ]
        offsets = []
        for feature, opcode, records in groups:
            if feature in self.features and records:
                begun = len(self.data)
                for record in records:
                    self.write(record)
                offsets.append(SummaryOffset(opcode, begun, len(self.data) - begun))
        summary_start = start if len(self.data) > start else 0
        offset_start = len(self.data) if "sum" in self.features else 0
        for offset in offsets if "sum" in self.features else ():
            self.write(offset)
        footer = bytes_of(Footer(summary_start, offset_start, 0))
        self.write(Footer(summary_start, offset_start, zlib.crc32(self.data[start:] + footer[:-4])))
        self.data += MAGIC
