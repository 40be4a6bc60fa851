"""Which MCAP files are one recording: a recorder may have split it by size or time, or gone on in a new file."""

from __future__ import annotations

import re
from collections.abc import Hashable, Sequence
from io import BytesIO
from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Chunk, Metadata
from mcap.stream_reader import StreamReader

from ema_bench_replay.bags.mcap_file import MAGIC
from ema_bench_replay.checked_yaml import read_yaml
from ema_bench_replay.errors import InputError

PART_NAME = "ema_twin_part"
"""Name of the MCAP metadata record that says which recording a file is of, and which of its parts, from 0 on."""
_HEAD = 4096
"""Bytes at a file's beginning within which that record ends."""
_NUMBER = re.compile(r"_(\d+)$")
_OF_OTHERS = re.compile(r"\.(db3|bag|(mcap|db3)\.(zstd|zst|lz4))$", re.IGNORECASE)


def how_to_convert(path: Path) -> str:
    """What to do where a file, or one in a folder, is a bag of a kind that is not read; empty where none is.

    rosbag2 writes SQLite, and packs whole files where it is told to: neither can be read from front to back.
    """
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    found = next((file for file in files if _OF_OTHERS.search(file.name)), None)
    if found is None:
        return ""
    source = found if found.suffix.lower() == ".bag" else found.parent
    convert = f"rosbags-convert --src {source} --dst NEW --dst-storage mcap"
    name = f"{found.name} " if path.is_dir() else ""
    return f"{name}is no plain MCAP; convert it: pip install rosbags, then {convert}"


def bag_parts(folder: Path) -> list[tuple[Path, ...]]:
    """The recordings in a folder, each with its MCAP files in their order."""
    return recordings_in(sorted(folder.glob("*.mcap")))


def recordings_in(files: Sequence[Path]) -> list[tuple[Path, ...]]:
    """These MCAP files, those that are one recording together and in its order, each part once.

    A file tells it itself where this project's recorder wrote it; else the metadata.yaml beside it, which rosbag2
    writes when it ends; else, where rosbag2 was killed, its names: FOLDER/FOLDER_0.mcap, FOLDER_1.mcap and so on.
    """
    found: dict[Hashable, list[tuple[int, Path]]] = {}
    for file in files:
        recording, part = _own_words(file) or _listed(file) or _named(file) or (file, 0)
        found.setdefault(recording, []).append((part, file))
    return [_in_order(parts) for parts in found.values()]


def _in_order(files: Sequence[tuple[int, Path]]) -> tuple[Path, ...]:
    """The files by their parts' numbers; of a cut file and what was recovered of it, the one with an index."""
    parts: dict[int, Path] = {}
    for number, file in sorted(files):
        if number not in parts or (_has_end(file) and not _has_end(parts[number])):
            parts[number] = file
    return tuple(parts.values())


def _has_end(file: Path) -> bool:
    try:
        with file.open("rb") as stream:
            stream.seek(-len(MAGIC), 2)
            return stream.read() == MAGIC
    except OSError:
        return False


def named_after(folder: Path) -> list[Path]:
    """The MCAP files in a folder that bear its name, with a number or without: what recorders write there."""
    return [file for file in sorted(folder.glob("*.mcap")) if folder.name in (file.stem, _NUMBER.sub("", file.stem))]


def name_of(parts: Sequence[Path]) -> str:
    """The recording's name: that of its file, without the part's number where there are several."""
    return _NUMBER.sub("", parts[0].stem) if len(parts) > 1 else parts[0].stem


def _own_words(file: Path) -> tuple[Hashable, int] | None:
    try:
        with file.open("rb") as stream:
            head = BytesIO(stream.read(_HEAD))
        for record in StreamReader(head, emit_chunks=True).records:
            if isinstance(record, Metadata) and record.name == PART_NAME:
                return record.metadata["recording"], int(record.metadata["part"])
            if isinstance(record, Chunk):
                break
    except (OSError, McapError, ValueError, KeyError, AssertionError, MemoryError, OverflowError):
        pass  # who reads the file tells what is wrong with it
    return None


def _listed(file: Path) -> tuple[Hashable, int] | None:
    try:
        content, _ = read_yaml(file.parent / "metadata.yaml")
        names = [Path(path).name for path in content["rosbag2_bagfile_information"]["relative_file_paths"]]
    except (InputError, KeyError, TypeError):
        return None
    return (file.parent, names.index(file.name)) if file.name in names else None


def _named(file: Path) -> tuple[Hashable, int] | None:
    folder = file.absolute().parent
    number = _NUMBER.search(file.stem)
    first = folder / f"{folder.name}_0.mcap"
    if number is None or file.stem[: number.start()] != folder.name or not first.exists():
        return None
    return folder, int(number[1])
