"""Reading what the command line names: recordings with their warnings, and JSON results written whole."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import find_recordings, load
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
    """The recordings that the paths name, cut to [start, end] seconds; warnings are printed, or refused if ``strict``."""
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


def write_json(path: Path | None, content: object) -> None:
    """Write a result as JSON, replacing the file; numbers that are not finite become null."""
    if path is None:
        return
    partial = path.with_name(f".{path.name}.partial")
    try:
        partial.write_text(json.dumps(_finite(content), indent=1, allow_nan=False) + "\n", "utf-8")
        os.replace(partial, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose a folder you may write to") from None


def _finite(content: object) -> object:
    if isinstance(content, dict):
        return {key: _finite(value) for key, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [_finite(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content
