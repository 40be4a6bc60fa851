"""Find which MCAP files form one recording: a recorder may have split it by size or time, or started a new file."""

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
from ema_bench_replay.recording_file import open_recording

PART_NAME = "ema_twin_part"
"""Name of the MCAP metadata record that names a file's recording and its part number, from 0."""
_HEAD = 4096
"""That record is within so many bytes of a file's beginning."""
_NUMBER = re.compile(r"_(\d+)$")
_OF_OTHERS = re.compile(r"\.(db3|bag|(mcap|db3)\.(zstd|zst|lz4))$", re.IGNORECASE)


def how_to_convert(path: Path) -> str:
    """The remedy if a file, or one in a folder, is a bag of an unsupported kind; empty if none is.

    rosbag2 writes SQLite, and compresses whole files if told to: neither can be read from front to back.
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
    """The recordings in a folder, each with its MCAP files in order."""
    return recordings_in(sorted(folder.glob("*.mcap")))


def recordings_in(files: Sequence[Path]) -> list[tuple[Path, ...]]:
    """These MCAP files grouped by recording, in order, each part once.

    The order comes from the file itself if this project's recorder wrote it; otherwise from the metadata.yaml next to
    it, which rosbag2 writes at its end; otherwise, if rosbag2 was killed, from the file names: FOLDER/FOLDER_0.mcap,
    FOLDER_1.mcap and so on.
    """
    found: dict[Hashable, list[tuple[int, Path]]] = {}
    for file in files:
        recording, part = _own_words(file) or _listed(file) or _named(file) or (file, 0)
        found.setdefault(recording, []).append((part, file))
    return [_in_order(parts) for parts in found.values()]


def _in_order(files: Sequence[tuple[int, Path]]) -> tuple[Path, ...]:
    """The files by part number; of a truncated file and its recovered copy, the one with an index."""
    parts: dict[int, Path] = {}
    for number, file in sorted(files):
        if number not in parts or (_has_end(file) and not _has_end(parts[number])):
            parts[number] = file
    return tuple(parts.values())


def _has_end(file: Path) -> bool:
    try:
        with open_recording(file) as stream:
            stream.seek(-len(MAGIC), 2)
            return stream.read() == MAGIC
    except (OSError, InputError):
        return False


def named_after(folder: Path) -> list[Path]:
    """The MCAP files in a folder that have its name, with or without a number, as recorders write them."""
    return [file for file in sorted(folder.glob("*.mcap")) if folder.name in (file.stem, _NUMBER.sub("", file.stem))]


def name_of(parts: Sequence[Path]) -> str:
    """The recording's name: that of its file, without the part number if there are several."""
    return _NUMBER.sub("", parts[0].stem) if len(parts) > 1 else parts[0].stem


def _own_words(file: Path) -> tuple[Hashable, int] | None:
    try:
        with open_recording(file) as stream:
            head = BytesIO(stream.read(_HEAD))
        for record in StreamReader(head, emit_chunks=True).records:
            if isinstance(record, Metadata) and record.name == PART_NAME:
                return record.metadata["recording"], int(record.metadata["part"])
            if isinstance(record, Chunk):
                break
    except (OSError, McapError, ValueError, KeyError, AssertionError, MemoryError, OverflowError):
        pass  # reading the file reports what is wrong with it
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
