"""``ema-twin export``: write a recording as a table for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ema_bench_replay.errors import InputError

from . import options
from .output import console, warn

EXAMPLES = """Examples:

ema-twin export recordings/BancoEMA_ramp_0.05 -o ramp.CSV

ema-twin export recordings/BancoEMA_ramp_0.05 -o ramp.parquet

CSV is the drive's own format (an imported trace is written back unchanged, but repaired); Parquet holds SI values."""


def run(
    run: options.Run,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="FILE.CSV or FILE.parquet.")],
    import_map: options.ImportMap = "siemens",
    force: options.Force = False,
) -> None:
    """Write a recording as the drive's CSV, or as Parquet."""
    from ema_bench_replay.outputs import new_file
    from ema_bench_replay.traces.import_map import load_map
    from ema_bench_replay.traces.trace_writer import write_trace

    from .inputs import load_runs

    kind = output.suffix.lower()
    if kind not in (".csv", ".parquet"):
        raise InputError(f"{output}: unknown kind '{output.suffix}'; name it .CSV or .parquet")
    found = load_runs([run], import_map=import_map)
    if len(found) != 1:
        raise InputError(f"{run}: holds {len(found)} recordings; export takes one, name it")
    if kind == ".csv":
        for signal in write_trace(found[0], output, load_map(import_map), force=force):
            warn(f"{output.name}: {signal} has no column in the drive's CSV; left out")
    else:
        import pyarrow
        from pyarrow import parquet

        with new_file(output, force=force) as file:
            parquet.write_table(pyarrow.table({"time": found[0].time, **found[0].signals}), file)
    console.print(f"{output}: {len(found[0])} samples of {', '.join(found[0].signals)}", soft_wrap=True)
