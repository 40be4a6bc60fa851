"""Read a recording in any supported format."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

OTHER_TRACES = (".txt", ".tsv", ".dat", ".asc", ".log")
"""How else than with .csv, which every program writes, the names of text traces end."""
TRACES = (".csv", *OTHER_TRACES)
"""How the names of text traces end. A binary one is refused as no text."""


def load(
    path: str | Path | Sequence[Path],
    *,
    import_map: str | Path = "siemens",
    progress: Callable[[float], None] = lambda share: None,
) -> Recording:
    """Read a recording: a text trace (through `import_map`), an MCAP, or the folder that import or a recorder wrote.

    For a split recording, give its folder or the sequence of its files. `progress` is called with the share read so
    far.

    Both positions of a run begin at zero (see `Recording.from_zero`). Raises InputError, in one line, if there is no
    recording or it cannot be used.
    """
    # each reader is imported only when needed: reading an MCAP needs no CSV reader
    files = [Path(path)] if isinstance(path, (str, Path)) else list(path)
    path = files[0]
    if not path.exists():
        raise InputError(f"{path}: no such file; give a CSV trace, an MCAP or the folder that import wrote")
    if path.is_dir() or path.suffix.lower() == ".mcap":
        from ema_bench_replay.bags.bag_reader import read_bag

        recording = read_bag(path if len(files) == 1 else files, progress=progress)
        return recording if recording.of_points else recording.from_zero()  # like traces and a live twin
    if path.suffix.lower() in TRACES:
        from ema_bench_replay.traces.import_map import load_map
        from ema_bench_replay.traces.trace_csv import read_trace

        return read_trace(path, load_map(import_map), progress)
    from ema_bench_replay.bags.bag_parts import how_to_convert

    if other := how_to_convert(path):
        raise InputError(f"{path}: {other}")
    kind = f"a file of kind {path.suffix!r}" if path.suffix else "a file without extension"
    raise InputError(f"{path}: {kind} is no recording; give a .csv trace, an .mcap or the folder that import wrote")


def load_runs(path: str | Path | Sequence[Path], *, import_map: str | Path = "siemens") -> list[Recording]:
    """All recordings of a file: several if it is a CSV whose import map names a column that separates runs.

    Otherwise as ``load``.
    """
    file = Path(path) if isinstance(path, (str, Path)) else Path(path[0])
    if file.suffix.lower() in TRACES and file.is_file():
        from ema_bench_replay.traces.import_map import load_map

        held = load_map(import_map)
        if held.run is not None:
            from ema_bench_replay.traces.many_runs import read_runs

            return read_runs(file, held)
    return [load(path, import_map=import_map)]
