"""A bag written while it happens: serialised messages of any type, on disk a sixth of a second after they arrived."""

from __future__ import annotations

import struct
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode

from ema_bench_replay.bags.bag_metadata import Topic, metadata_yaml
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.bags.mcap_file import MESSAGE_PREFIX, PREFIX_UNCOUNTED, McapFile, Messages
from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import new_file

#: A chunk is closed when it spans this long, in its messages' time or on the clock, ns.
LONGEST_CHUNK = 150_000_000
_LARGEST_CHUNK = 4 << 20
_PREFIX = struct.Struct("<BQHIQQ")  # MESSAGE_PREFIX, for one message


class _Channel(NamedTuple):
    number: int
    type_name: str
    type_hash: str
    qos: str
    records: bytearray  # of the chunk that is open
    offsets: list[int]
    log_times: list[int]


class StreamWriter:
    """Writes FOLDER/NAME.mcap, NAME being the folder's own, and its metadata.yaml when it finishes.

    What arrived longer ago than a chunk lasts is on disk if messages keep coming, or if `flush` is called now and then;
    a bag that was never finished can be read up to there. Not for several threads at once.
    """

    def __init__(self, folder: str | Path, *, force: bool = False) -> None:
        """Begin the file. Raises InputError where the bag exists (without `force`) or cannot be written."""
        self.folder = Path(folder)
        self.path = self.folder / f"{self.folder.name}.mcap"
        if self.path.exists() and not force:
            raise InputError(f"{self.path}: exists already; choose another folder, or --force to replace it")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / "metadata.yaml").unlink(missing_ok=True)
            self._stream = self.path.open("wb")
        except OSError as error:
            raise self._error(error) from None
        self._file = McapFile(self._stream)
        self._channels: dict[str, _Channel] = {}
        self._opened = 0  # monotonic ns at which the open chunk got its first message
        self._first = 0  # log time of that message
        self._size = 0

    def add_topic(self, topic: str, type_name: str, qos: str) -> None:
        """Announce a topic before its first message; `qos` as `bag_metadata.qos_profile` writes it, one or several."""
        definition = message_definition(type_name)
        number = self._file.add_channel(topic, type_name, definition.text, qos, definition.type_hash)
        self._channels[topic] = _Channel(number, type_name, definition.type_hash, qos, bytearray(), [], [])

    def write(self, topic: str, data: bytes, log_time: int, publish_time: int | None = None, sequence: int = 0) -> None:
        """Add one serialised message. Times in ns since the epoch; `log_time` is when it arrived."""
        channel = self._channels[topic]
        now = time.monotonic_ns()
        if self._size and (
            now - self._opened >= LONGEST_CHUNK
            or abs(log_time - self._first) >= LONGEST_CHUNK
            or self._size >= _LARGEST_CHUNK
        ):
            self.flush()
        if not self._size:
            self._opened, self._first = now, log_time
        length = MESSAGE_PREFIX.itemsize - PREFIX_UNCOUNTED + len(data)
        published = log_time if publish_time is None else publish_time
        prefix = (Opcode.MESSAGE, length, channel.number, sequence & 0xFFFFFFFF, log_time, published)
        channel.offsets.append(len(channel.records))
        channel.log_times.append(log_time)
        channel.records.extend(_PREFIX.pack(*prefix))
        channel.records.extend(data)
        self._size += MESSAGE_PREFIX.itemsize + len(data)

    def flush(self) -> None:
        """Put on disk what has arrived."""
        groups = [
            Messages(c.number, np.array(c.log_times, np.uint64), np.array(c.offsets, np.int64), bytes(c.records))
            for c in self._channels.values()
            if c.offsets
        ]
        if not groups:
            return
        with self._told():
            self._file.add_chunk(groups)
            self._stream.flush()
        for channel in self._channels.values():
            for part in (channel.records, channel.offsets, channel.log_times):
                part.clear()
        self._size = 0

    def finish(self) -> dict[str, int]:
        """Close the bag; returns how many messages each topic has in it."""
        self.flush()
        with self._told():
            self._file.finish()
            self._stream.close()
        counts = {topic: self._file.counts[channel.number] for topic, channel in self._channels.items()}
        topics = [Topic(name, c.type_name, c.type_hash, c.qos, counts[name]) for name, c in self._channels.items()]
        with new_file(self.folder / "metadata.yaml", force=True) as stream:
            stream.write(metadata_yaml(self.path.name, *self._file.span, topics).encode())
        return counts

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Raise InputError where nothing can be written, or nothing is kept, as in a file that was removed."""
        try:
            yield
            self.path.stat()
        except FileNotFoundError:
            with_it = f"{sum(self._file.counts.values())} messages"
            raise InputError(
                f"{self.path}: was removed while it was written, with {with_it}; record them again"
            ) from None
        except OSError as error:
            raise self._error(error) from None

    def _error(self, error: OSError) -> InputError:
        return InputError(f"{self.path}: cannot be written ({error.strerror}); choose another folder, or make room")
