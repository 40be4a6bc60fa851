"""``ema-twin simulate``: make a recording with the virtual bench."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ema_bench_replay.errors import InputError

from ..quantities import quantity
from . import options
from .output import console, warn

EXAMPLES = """Examples:

ema-twin simulate --model polito_bench --command ramp:0.05 -o ramp.mcap

ema-twin simulate --model better.yaml --command sine:0.02:1 --seconds 10 --seed 3 -o sine.CSV

ema-twin simulate --model emps --command triangle:0.05:1 -o slide.mcap      (a linear machine: 0.05 m/s)

Commands, of the output: ramp:SPEED, sine:SIZE:HZ, triangle:SPEED:HALF_PERIOD_S, step:SIZE:HALF_PERIOD_S, or a file: \
lines of time in s and position, or the YAML that plan wrote. Positions are in rad and speeds in rad/s; of a linear \
machine in m and m/s. With the prefix speed-, it is the speed that follows the shape (speed-sine:0.1:1 goes up to 0.1 \
rad/s, speed-ramp:0.1 gains 0.1 rad/s each second)."""


def run(
    model: options.ModelName,
    command: Annotated[
        str, typer.Option("--command", "-c", metavar="KIND:A:B|FILE", help="The command for the bench; see below.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="RUN", help="RUN.mcap or RUN.CSV to write.")],
    seconds: Annotated[
        float | None,
        typer.Option(
            metavar="S", parser=options.SECONDS, help="Duration in seconds; by default the command file's, else 20."
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option(metavar="N", parser=options.whole(0, 10**9), help="Seed of the sensors' noise.")
    ] = 0,
    noise: Annotated[bool, typer.Option("--noise/--no-noise", help="Add sensor noise.")] = True,
    start: Annotated[
        float,
        typer.Option(
            "--offset",
            metavar="SIZE",
            parser=options.number(-options.LARGEST, options.LARGEST, "rad or rad/s (m or m/s if linear)"),
            help="Added to the command, in rad or rad/s (m or m/s if the machine is linear).",
        ),
    ] = 0.0,
    phase: Annotated[
        float,
        options.bounded(
            "RAD", -options.LARGEST, options.LARGEST, "rad", "Phase that a periodic command begins with, in rad."
        ),
    ] = 0.0,
    step: options.Step = None,
    with_files: options.WithFiles = None,
    force: options.Force = False,
) -> None:
    """Run the virtual bench: the model driven by a command, through the bench's sensors, into a recording."""
    from dataclasses import replace

    from ema_bench_replay.bags.bag_writer import write_mcap
    from ema_bench_replay.traces.import_map import load_map
    from ema_bench_replay.traces.trace_writer import write_trace

    from ..model import load_model
    from ..own_effects import load_effects
    from ..simulation.command import parse_command
    from ..simulation.virtual_bench import virtual_bench

    if output.suffix.lower() not in (".mcap", ".csv"):
        raise InputError(f"{output}: unknown kind of recording '{output.suffix}'; name it .mcap or .CSV")
    parsed = parse_command(command, start=start, phase=phase)
    load_effects(with_files or ())
    if seconds is None:
        seconds = 20.0 if parsed.seconds is None else parsed.seconds
    driven = load_model(model)
    recording = virtual_bench(driven, parsed, seconds, seed=seed if noise else None, step=step)
    asked = parsed.highest_speed(recording.stamps * 1e-9) * driven.value("machine.gear_ratio")
    limit, unit = driven.value("drive.speed_limit"), driven.unit("drive.speed_limit")
    if asked > limit * (1.0 + 1e-6):
        warn(f"{parsed.text} needs {asked:.4g} {unit} at the motor; its drive.speed_limit is {limit:.4g} {unit}")
    recording = replace(recording, name=output.stem)
    if output.suffix.lower() == ".mcap":
        write_mcap(recording, output, force=force)
    else:
        for signal in write_trace(recording, output, load_map("siemens"), force=force):
            warn(f"{output.name}: {signal} has no column in the drive's CSV; left out")
    every = quantity(recording.sample_period, "s")
    console.print(
        f"{output}: {len(recording)} samples, {recording.duration:.2f} s, every {every}; "
        f"{', '.join(recording.signals)}",
        soft_wrap=True,
    )
