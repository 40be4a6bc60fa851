"""MCAP files in the ROS 2 profile, written one chunk at a time from records that are already bytes.

The library's own writer needs one Python call per message; this one takes a second of data at once. The records around
the messages (schemas, channels, statistics, summary) are the library's.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from ema_bench_replay.bags.bag_metadata import Topic
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.bags.spilled import Spilled

MAGIC = b"\x89MCAP0\r\n"
#: Prefix of each message: opcode, length of the rest, channel, sequence, log time, publish time.
MESSAGE_PREFIX = np.dtype(
    [
        *(("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4")),
        *(("log_time", "<u8"), ("publish_time", "<u8")),
    ]
)
#: Bytes of `MESSAGE_PREFIX` that the record's length does not include.
PREFIX_UNCOUNTED = 9

_INDEX_ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])


class Messages(NamedTuple):
    """Consecutive message records of one channel."""

    channel: int
    log_times: np.ndarray  # uint64 (n,), ns
    offsets: np.ndarray  # int64 (n,), where each record begins in `records`
    records: bytes


class Sink(Protocol):
    """Target of an MCAP: a file or file-like object."""

    def write(self, data: bytes, /) -> int:
        """Write all of the data."""


class McapFile:
    """An MCAP written to a stream that the caller opens and closes.

    Each chunk, and the end, is written in one piece and counts only once the stream has accepted it: after an error of
    the stream the same call may be repeated.
    """

    def __init__(self, stream: Sink, spill: Path | None = None) -> None:
        """Write the file's head. Data that grow with the file are kept on disk in the folder `spill`, if given."""
        self._stream = stream
        self._position = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._metadata: list[MetadataIndex] = []
        self._chunks = Spilled(spill)  # serialised index: the only part that grows with a long recording
        self._chunk_count = 0
        self._times: tuple[int, int] | None = None  # of the first and the last message
        self._counts: dict[int, int] = {}
        self._unwritten: list[McapRecord] = []  # schemas and channels, for the head of the next chunk
        self._compressor: zstandard.ZstdCompressor | None = zstandard.ZstdCompressor(level=1)
        self._write(MAGIC + bytes_of(Header(profile="ros2", library="ema_bench_replay")))

    @property
    def counts(self) -> dict[int, int]:
        """Messages written so far, by channel."""
        return dict(self._counts)

    @property
    def span(self) -> tuple[int, int]:
        """Log times of the first and the last message, ns; zeros if there is none."""
        return self._times or (0, 0)

    @property
    def size(self) -> int:
        """Bytes written so far."""
        return self._position

    def add_channel(self, topic: Topic) -> int:
        """Add a topic; returns the channel's number. Raises InputError if its type's definition is not found."""
        definition = message_definition(topic.type_name)
        schema = next((schema for schema in self._schemas if schema.name == topic.type_name), None)
        if schema is None:
            schema = Schema(len(self._schemas) + 1, definition.text.encode(), "ros2msg", topic.type_name)
            self._schemas.append(schema)
            self._unwritten.append(schema)
        metadata = {"offered_qos_profiles": topic.qos, "topic_type_hash": definition.type_hash}
        channel = Channel(len(self._channels) + 1, topic.name, "cdr", metadata, schema.id)
        self._channels.append(channel)
        self._unwritten.append(channel)
        self._counts[channel.id] = 0
        return channel.id

    def add_metadata(self, name: str, content: dict[str, str]) -> None:
        """Write a metadata record."""
        record = bytes_of(Metadata(name, content))
        self._metadata.append(MetadataIndex(self._position, len(record), name))
        self._write(record)

    def add_chunk(self, groups: list[Messages]) -> None:
        """Write messages as one compressed chunk, with their index."""
        head = b"".join(map(bytes_of, self._unwritten))
        data = b"".join([head, *(group.records for group in groups)])
        first = min(int(group.log_times.min()) for group in groups)
        last = max(int(group.log_times.max()) for group in groups)
        assert self._compressor is not None
        packed = self._compressor.compress(data)
        start = self._position
        written = [bytes_of(Chunk("zstd", packed, last, first, zlib.crc32(data), len(data)))]
        end = position = start + len(written[0])
        index_offsets = {}
        offset = len(head)
        for group in groups:
            index_offsets[group.channel] = position
            written.append(_index(group, offset))
            position += len(written[-1])
            offset += len(group.records)
        self._write(b"".join(written))
        self._unwritten = []
        for group in groups:
            self._counts[group.channel] += len(group.offsets)
        self._times = (first, last) if self._times is None else (min(first, self._times[0]), max(last, self._times[1]))
        self._chunk_count += 1
        index = ChunkIndex(
            chunk_start_offset=start,
            chunk_length=end - start,
            message_start_time=first,
            message_end_time=last,
            message_index_offsets=index_offsets,
            message_index_length=self._position - end,
            compression="zstd",
            compressed_size=len(packed),
            uncompressed_size=len(data),
        )
        self._chunks.add(bytes_of(index))

    def finish(self) -> None:
        """Write the summary and the file's end."""
        end = b"".join(map(bytes_of, self._unwritten)) + bytes_of(DataEnd(0))
        start = self._position + len(end)
        first, last = self.span
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=self._chunk_count,
            message_count=sum(self._counts.values()),
            message_end_time=last,
            message_start_time=first,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        summary, offsets = RecordBuilder(), []
        for opcode, records in (
            (Opcode.SCHEMA, b"".join(map(bytes_of, self._schemas))),
            (Opcode.CHANNEL, b"".join(map(bytes_of, self._channels))),
            (Opcode.STATISTICS, bytes_of(statistics)),
            (Opcode.CHUNK_INDEX, self._chunks.all()),
            (Opcode.METADATA_INDEX, b"".join(map(bytes_of, self._metadata))),
        ):
            if records:
                offsets.append(SummaryOffset(opcode, start + summary.count, len(records)))
                summary.write(records)
        offsets_start = start + summary.count
        for offset in offsets:
            offset.write(summary)
        data = summary.end()
        # The checksum covers the summary and the footer up to the checksum itself.
        crc = zlib.crc32(struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offsets_start), zlib.crc32(data))
        self._write(end + data + bytes_of(Footer(start, offsets_start, crc)) + MAGIC)
        self.close()

    def close(self) -> None:
        """Release everything needed only for writing, since a long recording has many files; the counts stay."""
        self._chunks.close()
        self._compressor = None  # some 0.2 MiB of memory
        for records in (self._schemas, self._channels, self._metadata, self._unwritten):
            records.clear()

    def _write(self, data: bytes) -> None:
        self._stream.write(data)
        self._position += len(data)


def _index(group: Messages, offset: int) -> bytes:
    entries = np.empty(len(group.offsets), _INDEX_ENTRY)
    entries["log_time"] = group.log_times
    entries["offset"] = group.offsets
    entries["offset"] += offset
    head = struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6 + entries.nbytes, group.channel, entries.nbytes)
    return head + entries.tobytes()


def bytes_of(record: McapRecord) -> bytes:
    """A record as it is in a file: opcode, length and content."""
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
