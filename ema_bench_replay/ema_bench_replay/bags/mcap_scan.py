"""Read an MCAP from front to back in blocks of message records, up to any damage.

A truncated or unfinished file has no summary, so none is required here. Message records come as blocks of bytes (a
chunk's content, or consecutive records if the writer used no chunks), to be decoded in bulk.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata, Schema
from mcap.stream_reader import StreamReader

from ema_bench_replay.bags.mcap_file import MAGIC
from ema_bench_replay.errors import InputError
from ema_bench_replay.recording_file import open_recording

_PLAIN_BLOCK = 4 << 20
_LARGEST_CHUNK = 256 << 20  # bytes, decompressed; writers make chunks of some MiB
_LARGEST_RATIO = 10_000  # of decompressed to compressed bytes: even all zeros compress no better
_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<BQHIQ")  # opcode, length, channel, sequence, log time
_FOOTER = struct.Struct("<BQQQI")  # opcode, length, starts of the summary and of its offsets, checksum
_WHOLE_HEAD = struct.Struct("<BQHIQQ")  # the same, and the publish time
_MESSAGE_HEAD = _WHOLE_HEAD.size  # bytes of a message record before its data
# Exceptions that the library's parsers raise on invalid bytes.
_UNREADABLE = (McapError, struct.error, ValueError, OSError, KeyError, AssertionError, MemoryError, OverflowError)


class Block(NamedTuple):
    """Messages of one or more channels in one buffer."""

    data: bytes
    offsets: np.ndarray  # int64 (n,): where each message's data begins
    sizes: np.ndarray  # int64 (n,): bytes of each message's data
    log_times: np.ndarray  # int64 (n,), ns


class Message(NamedTuple):
    """One message as stored."""

    channel: int
    sequence: int
    log_time: int  # ns
    publish_time: int  # ns
    data: bytes


class McapScan:
    """One MCAP file. After its blocks were read, `damage` describes what is wrong with it, or is None.

    `torn` is then the number of bytes after the last complete record; 0 without damage. While reading, `place` is how
    many of the file's `size` bytes have been read.
    """

    def __init__(self, path: Path) -> None:
        """Read which message types the file holds. Raises InputError if it is not an MCAP."""
        self.path = path
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.metadata: list[Metadata] = []
        self.damage: str | None = None
        self.torn = 0
        self.size = 0
        if not self._take_summary():
            self.schemas, self.channels = {}, {}
            for data in self._contents():
                self._messages(data, set())
        self.place = 0

    def blocks(self, wanted: set[int]) -> Iterator[Block]:
        """The messages of the wanted channels, in file order, up to any damage."""
        self.metadata, self.damage = [], None
        for data in self._contents():
            offsets, sizes, times = self._messages(data, wanted)
            if offsets:
                yield Block(data, np.array(offsets), np.array(sizes), np.array(times))

    def messages(self) -> Iterator[Message]:
        """Every message of all channels, in file order, up to any damage."""
        self.metadata, self.damage = [], None
        for data in self._contents():
            offsets, sizes, _ = self._messages(data, set(self.channels))
            for offset, size in zip(offsets, sizes, strict=True):
                _, _, channel, number, logged, published = _WHOLE_HEAD.unpack_from(data, offset - _MESSAGE_HEAD)
                yield Message(channel, number, logged, published, data[offset : offset + size])

    def _open(self) -> BinaryIO:
        try:
            return open_recording(self.path)
        except OSError as error:
            raise InputError(f"{self.path}: cannot be read ({error.strerror}); check its permissions") from None

    def _take_summary(self) -> bool:
        """Read schemas and channels from the file's summary; false if there is none with a channel."""
        with self._open() as file:
            self.size = file.seek(0, 2)
            try:
                file.seek(-(_FOOTER.size + len(MAGIC)), 2)
                opcode, _, start, _, _ = _FOOTER.unpack(file.read(_FOOTER.size))
                if opcode != Opcode.FOOTER or not start:
                    return False
                file.seek(start)
                for record in StreamReader(file, skip_magic=True, emit_chunks=True).records:
                    if isinstance(record, Chunk):  # the library would decompress it without bounds
                        return False
                    if isinstance(record, Schema):
                        self.schemas[record.id] = record
                    elif isinstance(record, Channel):
                        self.channels[record.id] = record
            except _UNREADABLE:
                return False
        return bool(self.channels)

    def _contents(self) -> Iterator[bytes]:
        """Decompressed message records; other records are processed on the way."""
        with self._open() as file:
            size = file.seek(0, 2)
            end = size - len(MAGIC)
            file.seek(max(end, 0))
            finished = file.read() == MAGIC and end > len(MAGIC)
            file.seek(0)
            if file.read(len(MAGIC)) != MAGIC:
                raise InputError(f"{self.path}: is no MCAP; give a bag or a CSV trace")
            whole = False
            while True:
                if file.tell() <= size:
                    self.place = file.tell()
                    self.torn = size - self.place
                head = file.read(_RECORD.size)
                if len(head) < _RECORD.size:
                    break
                opcode, length = _RECORD.unpack(head)
                if length > end:
                    break
                if opcode == Opcode.DATA_END:
                    whole = True
                    self.torn -= len(head) + length
                    break
                if opcode == Opcode.MESSAGE:
                    file.seek(-len(head), 1)
                    if not (data := self._plain(file, end)):
                        break
                elif opcode in (Opcode.CHUNK, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA):
                    content = file.read(length)
                    if len(content) < length:
                        break
                    if opcode != Opcode.CHUNK:
                        self._take(opcode, content)
                        continue
                    if (chunk := self._chunk(content)) is None:
                        return
                    data = chunk
                else:
                    file.seek(length, 1)
                    continue
                yield data
            if whole and finished:
                self.torn = 0
            else:
                self.damage = "the file is cut"

    def _plain(self, file: BinaryIO, end: int) -> bytes:
        """Consecutive message records outside chunks; the file position is then after the last complete one."""
        start = file.tell()
        data = file.read(_PLAIN_BLOCK)
        _, length = _RECORD.unpack_from(data)
        if _RECORD.size + length > len(data) and start + length < end:
            data += file.read(_RECORD.size + length - len(data))
        place = 0
        while place + _RECORD.size <= len(data):
            opcode, length = _RECORD.unpack_from(data, place)
            following = place + _RECORD.size + length
            if opcode not in (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL) or following > len(data):
                break
            place = following
        file.seek(start + place)
        return data[:place]

    def _chunk(self, content: bytes) -> bytes | None:
        """Records in a chunk; None, with the damage noted, if they cannot be read."""
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(content)))
            if chunk.uncompressed_size > min(_LARGEST_CHUNK, _LARGEST_RATIO * (len(chunk.data) + 1)):
                raise ValueError  # no valid writer produces this
            most = chunk.uncompressed_size + 1  # the content may be larger than declared
            if chunk.compression == "zstd":
                data = zstandard.ZstdDecompressor().stream_reader(chunk.data, read_across_frames=True).read(most)
            elif chunk.compression == "lz4":
                data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=most)
            elif chunk.compression == "":
                data = chunk.data
            else:
                how = f"its chunks are compressed with {chunk.compression!r}"
                raise InputError(f"{self.path}: {how}; write it with zstd, lz4 or none")
            whole = len(data) == chunk.uncompressed_size
            if not whole or (chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc):
                raise ValueError
        except InputError:
            raise
        except (zstandard.ZstdError, RuntimeError, *_UNREADABLE):
            self.damage = "a chunk is damaged"
            return None
        return data

    def _take(self, opcode: int, content: bytes) -> None:
        stream = ReadDataStream(BytesIO(content))
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self.schemas.setdefault(schema.id, schema)
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(stream)
                self.channels.setdefault(channel.id, channel)
            else:
                self.metadata.append(Metadata.read(stream))
        except _UNREADABLE:
            self.damage = "a record is damaged"

    def _messages(self, data: bytes, wanted: set[int]) -> tuple[list[int], list[int], list[int]]:
        """Offset, size and log time of each wanted message's data."""
        offsets: list[int] = []
        sizes: list[int] = []
        times: list[int] = []
        place, end = 0, len(data)
        while place + _MESSAGE.size <= end:  # no relevant record is shorter
            opcode, length, channel, _, time = _MESSAGE.unpack_from(data, place)
            following = place + _RECORD.size + length
            if following > end:
                break
            if opcode == Opcode.MESSAGE:
                if following < place + _MESSAGE_HEAD:
                    self.damage = "a record is damaged"
                elif channel in wanted:
                    offsets.append(place + _MESSAGE_HEAD)
                    sizes.append(length + _RECORD.size - _MESSAGE_HEAD)
                    times.append(time)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                self._take(opcode, data[place + _RECORD.size : following])
            place = following
        return offsets, sizes, times
