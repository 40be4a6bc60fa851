"""Reading what the command line names: recordings with their warnings, and JSON results written whole."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.outputs import new_file
from ema_bench_replay.recording import Recording

from .output import tracked, warn


def load_runs(
    paths: Sequence[Path],
    *,
    import_map: str = "siemens",
    start: float | None = None,
    end: float | None = None,
    strict: bool = False,
) -> list[Recording]:
    """The recordings that the paths name, cut to [start, end] s; warnings are printed, or refused if ``strict``."""
    files = [file for path in paths for file in find_recordings(path)]
    recordings = []
    for file in tracked(files, "reading"):
        recording = load(file, import_map=import_map)
        for warning in recording.warnings:
            if strict:
                raise InputError(f"{warning} (refused by --strict)")
            warn(warning)
        if start is not None or end is not None:
            recording = recording.between(start, end)
        recordings.append(recording)
    return recordings


def find_recordings(path: Path) -> list[Path]:
    """The recordings that a path names: itself, or, for a folder that holds folders of recordings, each of these."""
    if not path.is_dir() or any(path.glob("*.mcap")):
        return [path]
    inside = sorted(folder for folder in path.iterdir() if folder.is_dir() and any(folder.glob("*.mcap")))
    return inside or [path]


def write_json(path: Path | None, content: object) -> None:
    """Write a result as JSON, replacing the file; numbers that are not finite become null."""
    if path is not None:
        with new_file(path, force=True) as file:
            file.write((json.dumps(_finite(content), indent=1, allow_nan=False) + "\n").encode())


def _finite(content: object) -> object:
    if isinstance(content, dict):
        return {key: _finite(value) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [_finite(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content
