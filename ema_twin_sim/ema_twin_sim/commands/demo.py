"""``ema-twin demo``: the whole loop on the project's own recordings, in about half a minute."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from ema_bench_replay.errors import InputError

from . import compare, live, options
from .output import console

EXAMPLES = """Example:

ema-twin demo -o demo"""

RECORDINGS = "tests/recordings"
LIVE = "BancoEMA_sine_0.02_1Hz"
MARKER = ".ema-twin-demo"
"""A file in the folders that demos made: only these are written to again."""
ADDED = (
    (7.0, "backlash", {"width": 0.004}),
    (14.0, "stribeck_friction", {"torque": 0.08, "speed": 2.0}),
)
"""What is switched on in the running twin, and when [s of the replay]."""


def run(
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="Folder for what the demo makes.")
    ] = Path("demo"),
    rate: Annotated[
        float,
        typer.Option(min=0.0, max=1000.0, callback=options.finite, help="Speed of the live replay; 1: real time."),
    ] = 1.0,
) -> None:
    """Show the loop: a twin misses its bench, live; an effect is added, the error falls. Replaces what a demo left."""
    from ema_bench_replay.bags.bag_reader import read_bag
    from ema_bench_replay.bags.bag_writer import write_bag
    from ema_bench_replay.configuration import checkout
    from ema_bench_replay.traces.import_map import load_map
    from ema_bench_replay.traces.trace_csv import read_trace

    from ..comparison.compare import compare as compare_models
    from ..comparison.noise import noise_floors
    from ..model import load_model, save_model
    from ..nodes.live import Change, run_live
    from ..views.page import write_page
    from ..views.rerun_view import RerunView
    from ..views.screen import open_viewer

    begin = time.perf_counter()
    root = checkout()
    traces = sorted((root / RECORDINGS).glob("*.CSV")) if root else []
    if not traces:
        raise InputError(f"{RECORDINGS}: the demo's recordings are not here; run it from the project's checkout")
    _prepare(output)

    _chapter("1", "A recorded actuator", f"import {len(traces)} Siemens traces of a virtual bench → MCAP")
    recordings = [read_bag(write_bag(read_trace(f, load_map("siemens")), output, force=True)) for f in traces]
    for recording in recordings:
        console.print(f"  {recording.name}: {len(recording)} samples, {recording.duration:.1f} s")

    _chapter("2", "The stock model misses it", "ema-twin compare … --model polito_bench")
    stock = load_model("polito_bench")
    before = compare_models(recordings, stock)
    compare.show([before])

    played = next(recording for recording in recordings if recording.name == LIVE)
    _chapter(
        "3",
        "Live: replay, twin and monitor as ROS 2 nodes",
        f"{played.name} at {rate:g} × real time; backlash is switched on after {ADDED[0][0]:g} s, Stribeck friction "
        f"after {ADDED[1][0]:g} s, in the running twin",
    )
    rrd = output / "live.rrd"
    view = live.LiveView(RerunView(rrd, "ema-twin demo", noise_floors(stock)))
    view.tell(0.0, "the stock model beside the bench")
    follower = live.Follower(stock, played)
    follower.watchers.append(view.take)
    changes = []
    for moment, effect, parameters in ADDED:
        changes += [Change(0.0, f"effects.{effect}.{name}", value) for name, value in parameters.items()]
        changes.append(Change(moment, f"effects.{effect}.enabled", True))
        view.tell(moment, f"{effect} switched on")
    try:
        result = run_live(
            played,
            stock,
            rate=rate,
            changes=changes,
            on_pairs=follower.take,
            notify=lambda text: console.print(f"  [bold green]{text}[/bold green]", soft_wrap=True),
            record_to=output / "live",
        )
    finally:
        view.close()
    if result.interrupted:
        raise KeyboardInterrupt
    if not result.complete:
        counts = ", ".join(f"{name} {count}" for name, count in result.counts.items())
        raise InputError(
            f"demo: the monitor did not compare every sample ({counts}); free the machine and run it again"
        )

    _chapter("4", "The error falls", "ema-twin compare … --model polito_bench --model better.yaml")
    better = stock
    for _, effect, parameters in ADDED:
        better = better.with_effect(effect, parameters)
    better_file = save_model(better, output / "better.yaml", force=True)
    better = load_model(better_file)
    after = compare_models(recordings, better)
    compare.show([before, after])

    page = output / "demo.html"
    story = [
        f"A twin of the Politecnico di Torino bench beside {len(recordings)} recordings of a virtual bench (another "
        "program's simulation of it, sensors and noise included) that hides two effects. Nothing is estimated: the "
        "stock model, and the one with backlash and Stribeck friction added, integrate beside the same recorded speed "
        "setpoint.",
        f"Below, the first seconds of {played.name}. Left: bench and both twins. Right: measured minus twin. Click a "
        "name in the legend to hide it; drag in a plot to zoom, double-click to see all.",
    ]
    write_page(page, "EMA twin: the error falls", story, played, [stock, better], [before, after])
    _chapter("5", "Look at it", f"{time.perf_counter() - begin:.0f} s")
    console.print(f"  {page}   before and after, in any browser")
    console.print(f"  {rrd}   the live run: .venv/bin/rerun {rrd}")
    console.print(f"  {output / 'live'}   MCAP of all topics, for Foxglove, PlotJuggler or ros2 bag")
    console.print(f"  {better_file}   the better model")
    console.print("\nNow your own recordings:\n  .venv/bin/ema-twin import YOUR.CSV -o recordings")
    console.print("  .venv/bin/ema-twin compare recordings/* --model polito_bench")
    open_viewer(rrd)


def _prepare(output: Path) -> None:
    """Make the folder, or clear what an earlier demo left in it; any other folder with something in it is refused."""
    import shutil

    try:
        if output.is_dir() and any(output.iterdir()) and not (output / MARKER).is_file():
            raise InputError(f"{output}: holds files that no demo made (no {MARKER}); choose another folder with -o")
        output.mkdir(parents=True, exist_ok=True)
        (output / MARKER).write_text("The next ema-twin demo replaces what is in this folder.\n")
        shutil.rmtree(output / "live", ignore_errors=True)
    except OSError as error:
        raise InputError(f"{output}: cannot be written ({error.strerror}); choose a folder you may write to") from None


def _chapter(number: str, title: str, detail: str) -> None:
    console.print(f"\n[bold cyan]{number}. {title}[/bold cyan]  [dim]{detail}[/dim]\n", soft_wrap=True)
