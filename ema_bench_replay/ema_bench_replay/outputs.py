"""Output files: an existing one is refused, and none is ever left half written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from ema_bench_replay.errors import InputError


@contextmanager
def new_file(path: Path, *, force: bool = False) -> Iterator[BinaryIO]:
    """A binary file to write, which takes its name when it is whole; folders above it are made.

    Raises InputError where the file exists already and `force` is not set, or where it cannot be written.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a folder; name a file")
    if path.exists() and not force:
        raise InputError(f"{path}: exists already; give another name, or --force to replace it")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = part.open("wb")
    except OSError as error:
        raise _cannot_write(path, error) from None
    try:
        try:
            with file:
                yield file
            part.replace(path)
        except OSError as error:
            raise _cannot_write(path, error) from None
    except BaseException:
        with suppress(OSError):
            part.unlink()
        raise


def _cannot_write(path: Path, error: OSError) -> InputError:
    return InputError(f"{path}: cannot be written ({error.strerror}); choose another folder with -o")
