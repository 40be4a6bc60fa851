"""One file of a bag while it is written: complete up to its last chunk, and checked for removal."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path

from ema_bench_replay.bags.bag_parts import PART_NAME
from ema_bench_replay.bags.mcap_file import McapFile

NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
"""Errors after which the same file can be continued once there is space."""


class BagFile:
    """An MCAP on disk to which chunks are added. A failed call raises OSError, and may be repeated."""

    def __init__(self, path: Path, recording: str, part: int) -> None:
        """Create the file, part number `part` (from 0) of a `recording`; it must not exist."""
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
        """Whether the written file still exists under its name."""
        try:
            found = self.path.stat()
        except OSError:
            return False
        return (found.st_dev, found.st_ino) == self._made and found.st_size >= self._size

    @property
    def messages(self) -> int:
        """Number of messages written."""
        return sum(self.content.counts.values())

    def finish(self) -> None:
        """Write the index and close the file."""
        if not self.is_whole and self._descriptor is not None:
            self.content.finish()
            self.is_whole = True
            self.close()

    def close(self) -> None:
        """Close the file without an index."""
        if self._descriptor is not None:
            with suppress(OSError):
                os.close(self._descriptor)
            self._descriptor = None
            self.content.close()

    def write(self, data: bytes) -> int:
        """Write all of the data or nothing: if it does not fit, the file is truncated again."""
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
