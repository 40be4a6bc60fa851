"""Open the file of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from ema_bench_replay.errors import InputError


def open_recording(path: Path) -> BinaryIO:
    """Open a file for reading. Raises InputError if it is a named pipe, which would wait for its writer for ever.

    A pipe cannot be read twice either, as a check before the reading needs. Raises OSError as ``Path.open`` does.
    """
    if path.is_fifo():
        raise InputError(f"{path}: is a pipe, not a file; write its content to a file and give that")
    return path.open("rb")
