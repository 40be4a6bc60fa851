"""Write a bag in real time: serialised messages of any type, on disk a tenth of a second after arrival."""

from __future__ import annotations

import struct
import time
import uuid
from collections import Counter, deque
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode

from ema_bench_replay.bags.bag_file import NO_ROOM, BagFile
from ema_bench_replay.bags.bag_metadata import FileOfBag, Topic, metadata_yaml
from ema_bench_replay.bags.bag_parts import named_after
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.bags.mcap_file import MESSAGE_PREFIX, PREFIX_UNCOUNTED, Messages
from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import write_text

#: A chunk is closed when it spans this long, in message time or wall time, ns.
LONGEST_CHUNK = 100_000_000
#: Messages that cannot be written now wait in memory up to this many bytes; further ones are lost.
LARGEST_WAITING = 64 << 20
#: Time between attempts to write a bag that cannot be written, ns.
PATIENCE = 500_000_000
_LARGEST_CHUNK = 4 << 20
_PREFIX = struct.Struct("<BQHIQQ")  # MESSAGE_PREFIX, for one message


class _Channel(NamedTuple):
    topic: Topic
    number: int  # in every file
    records: bytearray  # of the chunk that is open
    offsets: list[int]
    log_times: list[int]


class StreamWriter:
    """Writes FOLDER/NAME.mcap, where NAME is the folder's, and its metadata.yaml at the end.

    The next files are NAME_1.mcap, NAME_2.mcap and so on. A new one begins when the current one reaches its maximum
    size or duration, was removed, or fails for a reason other than lack of space. While nothing can be written,
    messages wait in memory and are written later.

    Messages older than one chunk are on disk if messages keep coming, or if `flush` is called regularly; an unfinished
    bag can be read up to there. Not thread-safe.

    Attributes:
        path: the newest file.
        problem: why nothing can be written now, in a sentence; empty if there is no problem.
    """

    def __init__(
        self, folder: str | Path, *, force: bool = False, max_size: int = 0, max_duration: float = 0.0
    ) -> None:
        """Begin the first file. A new file begins after `max_size` bytes or `max_duration` s, unless these are 0.
        Raises InputError if the bag exists (without `force`) or cannot be written.
        """
        self.folder = Path(folder)
        self.problem = ""
        self._recording = uuid.uuid4().hex
        self._limits = max_size, round(max_duration * 1e9)
        self._channels: dict[str, _Channel] = {}
        self._files: list[BagFile] = []
        self._current: BagFile | None = None
        self._waiting: deque[list[Messages]] = deque()
        self._dropped: Counter[int] = Counter()  # messages that did not fit in memory either, by channel
        self._again = 0  # monotonic ns before which the disk is not tried again
        self._opened = 0  # monotonic ns at which the open chunk got its first message
        self._first = 0  # log time of that message
        self._size = 0
        self.path = self.folder / f"{self.folder.name}.mcap"
        before = named_after(self.folder)
        if before and not force:
            raise InputError(f"{before[0]}: exists already; choose another folder, or --force to replace it")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            for file in (*before, self.folder / "metadata.yaml"):
                file.unlink(missing_ok=True)
            self._begin(self.path)
        except OSError as error:
            raise InputError(f"{_cannot(self.path, error)}; choose another folder, or make room") from None

    @property
    def written(self) -> dict[str, int]:
        """Messages in the bag's existing files, by topic."""
        counts = _sum(file.content.counts for file in self._files if file.is_kept)
        return {topic: counts[channel.number] for topic, channel in self._channels.items()}

    @property
    def lost(self) -> dict[str, int]:
        """Received messages that are in no existing file and not waiting for one, by topic."""
        counts = _sum([self._dropped, *(file.content.counts for file in self.removed)])
        return {topic: counts[channel.number] for topic, channel in self._channels.items()}

    @property
    def waiting(self) -> int:
        """Messages that could not be written yet."""
        return sum(len(group.offsets) for chunk in self._waiting for group in chunk)

    @property
    def removed(self) -> list[BagFile]:
        """Files with messages that no longer exist under their name."""
        return [file for file in self._files if file.messages and not file.is_kept]

    @property
    def unfinished(self) -> list[Path]:
        """Files without an index."""
        return [f.path for f in self._files if f is not self._current and not f.is_whole and f.is_kept]

    @property
    def files(self) -> list[Path]:
        """The bag's existing files."""
        return [file.path for file in self._files if file.is_kept]

    def add_topic(self, topic: str, type_name: str, qos: str) -> None:
        """Add a topic before its first message; `qos` as from `bag_metadata.qos_profile`, one or several."""
        message_definition(type_name)  # one that is not installed is refused before anything is added
        channel = _Channel(Topic(topic, type_name, qos), len(self._channels) + 1, bytearray(), [], [])
        self._channels[topic] = channel
        if self._current is not None:
            _announce(self._current, channel)

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
        """Write received messages to disk, or keep them until that is possible; `problem` says which."""
        self._close_chunk()
        if self._waiting and time.monotonic_ns() >= self._again:
            self._write_waiting()
        while sum(len(group.records) for chunk in self._waiting for group in chunk) > LARGEST_WAITING:
            self._drop(self._waiting.pop())  # the newest, so that there is one gap after the kept ones

    def finish(self) -> dict[str, int]:
        """Close the bag; returns the number of messages per topic. What cannot be written now is lost.

        Raises InputError if its metadata.yaml cannot be written.
        """
        self._close_chunk()
        if self._waiting:
            self._write_waiting()
        while self._waiting:
            self._drop(self._waiting.popleft())
        self._current = None
        for file in self._files:
            with suppress(OSError):
                file.finish()
            file.close()
        self._write_metadata()
        return self.written

    def _close_chunk(self) -> None:
        groups = [
            Messages(c.number, np.array(c.log_times, np.uint64), np.array(c.offsets, np.int64), bytes(c.records))
            for c in self._channels.values()
            if c.offsets
        ]
        if not groups:
            return
        for channel in self._channels.values():
            for part in (channel.records, channel.offsets, channel.log_times):
                part.clear()
        self._size = 0
        self._waiting.append(groups)

    def _drop(self, chunk: list[Messages]) -> None:
        for group in chunk:
            self._dropped[group.channel] += len(group.offsets)

    def _write_waiting(self) -> None:
        try:
            while self._waiting:
                self._file_for(self._waiting[0]).content.add_chunk(self._waiting[0])
                self._waiting.popleft()
        except OSError as error:
            self._again = time.monotonic_ns() + PATIENCE
            remedy = "make room" if error.errno in NO_ROOM else "it is tried again until it can be"
            self.problem = f"{_cannot(self.path if self._current else self.folder, error)}; {remedy}"
            if self._current is not None and error.errno not in NO_ROOM:
                self._leave(self._current)
        else:
            if self.problem:
                self.problem = ""
                self._finish_others()

    def _file_for(self, chunk: list[Messages]) -> BagFile:
        """The file for a chunk: the current one, or the next."""
        file = self._current
        if file is not None and (not file.is_kept or self._is_full(file, chunk)):
            self._leave(file)
        if self._current is None:
            self._begin(self._next_path())
        assert self._current is not None
        return self._current

    def _is_full(self, file: BagFile, chunk: list[Messages]) -> bool:
        max_size, max_duration = self._limits
        if not file.messages:
            return False
        last = max(int(group.log_times.max()) for group in chunk)
        too_long = max_duration and last - file.content.span[0] > max_duration
        return bool(too_long or (max_size and file.content.size >= max_size))

    def _next_path(self) -> Path:
        """An unused path. A removed folder is created again, but none above it: a disk may be gone."""
        self.folder.mkdir(exist_ok=True)
        number = len(self._files)
        while (path := self.folder / f"{self.folder.name}_{number}.mcap").exists():
            number += 1
        return path

    def _begin(self, path: Path) -> None:
        file = BagFile(path, self._recording, len(self._files))
        for channel in self._channels.values():
            _announce(file, channel)
        self._files.append(file)
        self._current, self.path = file, path

    def _leave(self, file: BagFile) -> None:
        """Continue without this file; it is finished now, or later if only space is lacking."""
        self._current = None
        try:
            file.finish()
        except OSError as error:
            if error.errno not in NO_ROOM or not file.is_kept:  # a removed one would keep its disk space
                file.close()
        if not file.messages and file.is_kept:
            file.close()
            self._files.remove(file)
            with suppress(OSError):
                file.path.unlink()

    def _finish_others(self) -> None:
        for file in self._files:
            if file is not self._current:
                with suppress(OSError):
                    file.finish()

    def _write_metadata(self) -> None:
        files = [file for file in self._files if file.is_kept and file.is_whole]
        if not files:
            return
        counts = _sum(file.content.counts for file in files)
        topics = {channel.topic: counts[channel.number] for channel in self._channels.values()}
        listed = [FileOfBag(file.path.name, *file.content.span, file.messages) for file in files]
        write_text(self.folder / "metadata.yaml", metadata_yaml(listed, topics), force=True)


def _announce(file: BagFile, channel: _Channel) -> None:
    number = file.content.add_channel(channel.topic)
    assert number == channel.number  # topics have the same numbers in every file


def _sum(counts: Iterable[Mapping[int, int]]) -> Counter[int]:
    return sum(map(Counter, counts), Counter())


def _cannot(path: Path, error: OSError) -> str:
    return f"{path}: cannot be written ({error.strerror})"
