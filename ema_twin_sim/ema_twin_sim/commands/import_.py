"""``ema-twin import``: convert a drive's CSV traces, or one topic of a bag, to MCAP recordings."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from ema_bench_replay.errors import InputError

from ..listing import number_of
from ..quantities import quantity
from . import options
from .output import console, counted

EXAMPLES = """Examples:

ema-twin import BancoEMA_ramp_0.05.CSV -o recordings

ema-twin import traces/*.CSV --map my_drive.yaml -o recordings

ema-twin import rigs.mcap --topic /rig7/bench/state -o recordings"""


def run(
    files: Annotated[
        list[Path], typer.Argument(metavar="RUN.CSV…", help="CSV traces of the drive; with --topic bags.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Folder to write to.")] = Path(
        "recordings"
    ),
    import_map: options.ImportMap = "siemens",
    topic: Annotated[
        str | None, typer.Option(metavar="TOPIC", help="Topic of the states to import, if a bag holds several rigs.")
    ] = None,
    strict: options.Strict = False,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Import CSV traces as MCAP recordings (DIR/STEM/STEM.mcap) that ros2 bag, Foxglove, PlotJuggler and rerun open."""
    from ema_bench_replay.bags.bag_reader import read_bag
    from ema_bench_replay.bags.bag_writer import write_bag
    from ema_bench_replay.traces.import_map import load_map
    from ema_bench_replay.traces.trace_csv import read_trace

    from .inputs import refuse_inputs, warned_or_refused, write_json

    chosen = load_map(import_map)
    _check_files(files, topic)
    refuse_inputs(files, json)
    written = []
    begin = time.perf_counter()
    with warned_or_refused(strict=strict) as warnings_of:
        for file, of_file in _each(files):
            if topic is None:
                recording = read_trace(file, chosen, of_file)
            else:
                recording = read_bag(file, topic=topic, progress=of_file).from_zero()
                recording = replace(recording, name="_".join([recording.name, *topic.split("/")[1:]]))
            warnings_of(recording)
            path = write_bag(recording, output, force=force)
            written.append(
                {
                    "source": str(file),
                    "recording": str(path),
                    "samples": len(recording),
                    "duration": recording.duration,
                    "signals": list(recording.signals),
                    "warnings": list(recording.warnings),
                }
            )
            sought = [signal.signal for signal in chosen.signals] if topic is None else []
            absent = [signal for signal in sought if signal not in recording.signals]
            every = quantity(recording.sample_period, "s")
            held = f"{len(recording)} samples, {recording.duration:.2f} s, every {every}"
            if recording.of_points:
                held = f"{len(recording)} operating points"
            console.print(
                f"{file.name}: {held}; {', '.join(recording.signals)}"
                + (f" (not in this trace: {', '.join(absent)})" if absent else "")
                + f"\n  → {path}",
                soft_wrap=True,
            )
    size = sum(one.stat().st_size for file in files for one in (file.glob("*.mcap") if file.is_dir() else [file]))
    seconds = time.perf_counter() - begin
    console.print(f"{number_of(len(files), 'file')}, {quantity(size, 'B')} in {seconds:.2f} s", style="dim")
    write_json(json, {"imported": written})


def _each(files: list[Path]) -> Iterator[tuple[Path, Callable[[float], None]]]:
    """Yield each file with a callback for the fraction read of it; a bar or log lines show the progress."""
    with counted(len(files), "importing") as done:
        for file in files:
            yield file, partial(done.within, file.name)
            done(file.name)


def _check_files(files: list[Path], topic: str | None) -> None:
    """Refuse unsuitable files before anything is written: no trace (with ``topic``: no bag), or two files whose
    recordings would have the same name.
    """
    stems: dict[str, Path] = {}
    for file in files:
        if topic is not None:
            if not file.is_dir() and file.suffix.lower() != ".mcap":
                raise InputError(f"{file}: is not a bag and has no topics; leave --topic out")
        elif file.is_dir():
            raise InputError(f"{file}: is a folder; give its traces: {file}/*.CSV")
        elif file.suffix.lower() == ".mcap":
            raise InputError(f"{file}: is already a recording; use it directly with compare or live")
        if file.stem in stems:
            raise InputError(
                f"{file}: has the same name as {stems[file.stem]}; import one of them to another folder (-o)"
            )
        stems[file.stem] = file
