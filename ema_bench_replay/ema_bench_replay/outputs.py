"""Output files: existing ones are refused, and none is left half written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from ema_bench_replay.errors import InputError

_DESCRIPTORS = ("/dev/stdout", "/dev/stderr", "/dev/fd/", "/proc/")  # files held open by somebody else


@contextmanager
def new_file(path: Path, *, force: bool = False) -> Iterator[BinaryIO]:
    """A binary file to write; it gets its name when it is complete, and missing folders are created.

    A link is kept and its target written. A file that is not regular (a pipe, /dev/null, /dev/stdout) is written to
    directly. Raises InputError if the file exists already and `force` is not set, or if it cannot be written.
    """
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder; name a file")
        exists = path.exists()
        if exists and (not path.is_file() or str(path).startswith(_DESCRIPTORS)):
            with path.open("ab") as stream:
                yield stream
            return
        if exists and not force:
            raise InputError(f"{path}: exists already; give another name, or --force to replace it")
        target = Path(os.path.realpath(path))
        part = target.with_name(f".{target.name}.{os.getpid()}.part")
        target.parent.mkdir(parents=True, exist_ok=True)
        file = part.open("wb")
        try:
            with file:
                yield file
            part.replace(target)
        except BaseException:
            with suppress(OSError):
                part.unlink()
            raise
    except BrokenPipeError:
        raise  # the reader of a pipe has left: the file name is not at fault
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"{path}: cannot be written ({reason}); choose another folder with -o") from None


def write_text(path: Path, text: str, *, force: bool = False) -> None:
    """Write a whole text file; as for `new_file`."""
    with new_file(path, force=force) as file:
        file.write(text.encode())
