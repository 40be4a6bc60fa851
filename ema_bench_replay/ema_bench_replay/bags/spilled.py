"""Bytes that grow with a recording and are read once, at its end: kept mostly on disk, not in memory."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import BinaryIO

#: Bytes in memory beyond which they are moved to disk.
LARGEST = 1 << 16


class Spilled:
    """An append-only buffer of bytes.

    They go to an unnamed file, which disappears with the process. While it cannot be written, they stay in memory.
    """

    def __init__(self, folder: Path | None) -> None:
        """Keep the bytes on disk in a folder; without one, in memory."""
        self._folder = folder
        self._file: BinaryIO | None = None
        self._on_disk = 0
        self._try_at = LARGEST
        self._kept = bytearray()

    def add(self, data: bytes) -> None:
        """Append data."""
        self._kept += data
        if self._folder is not None and len(self._kept) >= self._try_at:
            try:
                self._spill(self._folder)
            except OSError:
                self._try_at = len(self._kept) + LARGEST
            else:
                self._kept = bytearray()
                self._try_at = LARGEST

    def all(self) -> bytes:
        """All appended bytes. Raises OSError if they cannot be read back."""
        if self._file is None:
            return bytes(self._kept)
        self._file.seek(0)
        data = self._file.read(self._on_disk)
        if len(data) < self._on_disk:
            raise OSError("what was spilled to disk is gone")
        return data + self._kept

    def close(self) -> None:
        """Discard the bytes."""
        self._kept = bytearray()
        self._on_disk, self._folder = 0, None
        if self._file is not None:
            self._file.close()
            self._file = None

    def _spill(self, folder: Path) -> None:
        if self._file is None:
            self._file = tempfile.TemporaryFile(buffering=0, dir=folder)  # noqa: SIM115 - closed with the recording
        done = 0
        while done < len(self._kept):
            done += os.pwrite(self._file.fileno(), self._kept[done:], self._on_disk + done)
        self._on_disk += done
