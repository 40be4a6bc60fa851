"""One file of a bag while it is written: whole up to its last chunk, and watched for its removal."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path

from ema_bench_replay.bags.bag_parts import PART_NAME
from ema_bench_replay.bags.mcap_file import McapFile, Messages

NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
"""Errors after which the same file can be gone on with, once there is room."""


class BagFile:
    """An MCAP on disk that chunks are added to. Each call raises OSError where it fails, and may then be made again."""

    def __init__(self, path: Path, recording: str, part: int) -> None:
        """Make the file, which is this part, from 0 on, of a `recording`; none may be there."""
        self.path = path
        self.is_whole = False
        self._size = 0
        self._descriptor: int | None = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        try:
            made = os.fstat(self._descriptor)
            self._made = made.st_dev, made.st_ino
            self.content = McapFile(self, path.parent)
            self.content.add_metadata(PART_NAME, {"recording": recording, "part": str(part)})
        except BaseException:
            os.close(self._descriptor)
            with suppress(OSError):
                path.unlink()
            raise

    @property
    def is_kept(self) -> bool:
        """Whether what was written is there, under the name that it was written to."""
        try:
            found = self.path.stat()
        except OSError:
            return False
        return (found.st_dev, found.st_ino) == self._made and found.st_size >= self._size

    @property
    def messages(self) -> int:
        """How many messages were written."""
        return sum(self.content.counts.values())

    def add_chunk(self, groups: list[Messages]) -> None:
        """Write messages of all channels as one chunk."""
        self.content.add_chunk(groups)

    def finish(self) -> None:
        """Write the index and close the file."""
        if not self.is_whole and self._descriptor is not None:
            self.content.finish()
            self.is_whole = True
            self.close()

    def close(self) -> None:
        """Let go of the file as it is."""
        if self._descriptor is not None:
            with suppress(OSError):
                os.close(self._descriptor)
            self._descriptor = None
            self.content.close()

    def write(self, data: bytes) -> int:
        """All of the data, or nothing: where it does not fit, what was written of it is taken back."""
        assert self._descriptor is not None
        done = 0
        try:
            while done < len(data):
                done += os.pwrite(self._descriptor, data[done:], self._size + done)
        except OSError:
            with suppress(OSError):
                os.ftruncate(self._descriptor, self._size)
            raise
        self._size += done
        return done
