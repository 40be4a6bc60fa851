"""``ema-twin demo``: the whole loop on the project's own recordings. The search is not told what is missing."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ema_bench_replay.errors import InputError

from ..listing import listed
from ..quantities import quantity
from . import options
from .output import console, say, status, warn

if TYPE_CHECKING:
    from ..discovery.discover import Discovery
    from ..model import Model

EXAMPLES = """Example:

ema-twin demo -o demo"""

RECORDINGS = "tests/recordings"
LIVE = "BancoEMA_sine_0.02_1Hz"
MARKER = ".ema-twin-demo"
"""Marker file in folders that a demo made; only such folders are written to again."""


def run(
    output: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Output folder of the demo.")] = Path(
        "demo"
    ),
    rate: options.Rate = 1.0,
) -> None:
    """Run the whole loop: compare a model with recordings, find the missing effects, switch them on live.

    Overwrites an earlier demo.
    """
    from ema_bench_replay.bags.bag_reader import read_bag
    from ema_bench_replay.bags.bag_writer import write_bag
    from ema_bench_replay.configuration import checkout
    from ema_bench_replay.traces.import_map import load_map
    from ema_bench_replay.traces.trace_csv import read_trace

    from ..comparison.compare import compare
    from ..discovery.discover import discover
    from ..fitting.fit import fit_model
    from ..measured.noise import noise_of
    from ..model import load_model, save_model
    from ..nodes.live import run_live
    from ..nodes.live_session import Change
    from ..report.content import ROLES
    from ..views.rerun_view import RerunView
    from ..views.screen import start_viewer, why_not_shown
    from ..words.fit_findings import fit_findings_of
    from ..words.sentences import effect_words, fit_sentences
    from .live_error import LINES_ARE, ErrorPrinter
    from .live_view import LiveView
    from .report_page import fitting_moved, weighed, write_page
    from .rerun_file import write_rrd
    from .shown_comparison import show_comparison
    from .shown_fit import errors_table
    from .shown_search import show_search

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

    _chapter("2", "The stock model does not match it", "ema-twin compare … --model polito_bench")
    stock = load_model("polito_bench")
    noise = noise_of(recordings, stock)
    before = compare(recordings, stock, noise=noise)
    show_comparison([before])

    _chapter("3", "Which effects does it lack?", "ema-twin discover … --model polito_bench -o better.yaml")
    with status() as progress:
        found = discover(recordings, stock, progress=progress)
    show_search(found)
    better_file = save_model(found.model, output / "better.yaml", force=True)

    played = next(recording for recording in recordings if recording.name == LIVE)
    beside, moments = switched_off(stock, found.model), moments_of(_most_telling_first(found), played.duration)
    switched = [f"{effect_words(name)} is switched on after {moment:g} s" for name, moment in moments.items()]
    changing = f"in the running twin, {listed(switched)}" if switched else "nothing is switched on in the twin"
    _chapter("4", "Live: replay, twin and monitor as ROS 2 nodes", f"{played.name} at {rate:g} × real time; {changing}")
    rrd = output / "live.rrd"
    view = LiveView(RerunView(rrd, "ema-twin demo", noise, model=stock))
    view.tell(0.0, "stock model and bench")
    say(LINES_ARE)
    printer = ErrorPrinter(noise, played)
    printer.watchers.append(view.take)
    for name, moment in moments.items():
        view.tell(moment, f"{effect_words(name)} switched on")
    try:
        result = run_live(
            played,
            beside,
            rate=rate,
            changes=[Change(moment, f"effects.{name}.enabled", True) for name, moment in moments.items()],
            on_pairs=printer.take,
            notify=lambda text: console.print(f"  [bold green]{text}[/bold green]", soft_wrap=True),
            record_to=output / "live",
        )
    finally:
        view.close()
    if result.interrupted:
        raise KeyboardInterrupt
    if result.unrecorded:
        warn(f"{output / 'live'}: the recording is incomplete: {result.unrecorded}")
    if not result.complete:
        counts = ", ".join(f"{name} {count}" for name, count in result.counts.items())
        raise InputError(
            f"demo: the monitor did not compare every sample ({counts}); free the machine and run it again"
        )

    _chapter(
        "5", "The errors of three models", "ema-twin fit … --model better.yaml -o fitted.yaml, and compare all three"
    )
    say(
        "Three models: polito_bench unchanged; better.yaml with the effects found; and fitted.yaml, the same with all "
        "parameters fitted to the simulated loop, to see whether that reduces the current's error further.\n"
    )
    better = load_model(better_file)
    after = compare(recordings, better, noise=noise)
    with status() as progress:
        fitted = fit_model(recordings, better, progress=progress)
    fitted_file = save_model(fitted.model, output / "fitted.yaml", force=True)
    console.print(errors_table(fitted))
    models, fit = (stock, better, load_model(fitted_file)), fit_findings_of(fitted)
    comparisons = (before, after, compare(recordings, models[2], noise=noise))
    show_comparison(comparisons)
    errors = [each.overall for each in comparisons]
    both = " to ".join(quantity(error["current"]["rmse"], "A") for error in errors[:2])
    floor = quantity(errors[0]["current"]["noise_floor"], "A")
    say(
        f"\nWith the effects found, the current's error goes from {both}; the sensors' noise is {floor}. "
        f"{fit_sentences(errors[1], errors[2], ['current'], fit)}",
        style="bold",
    )

    page = output / "demo.html"
    story = (
        f"A twin of the Politecnico di Torino bench and {len(recordings)} recordings of a virtual bench (another "
        "program's simulation of it, sensors and noise included) with two hidden effects. The search was not told."
    )
    views = output / "found.rrd"
    with status() as progress:
        progress("writing the report and the views")
        labels, findings = ("polito_bench", better_file, fitted_file), weighed(found)
        notes = write_page(
            page, recordings, models, labels, findings, fit=fit, comparisons=comparisons, story=story, force=True
        )
        shown = 3 if fitting_moved(models, findings, fit) else 2  # the page decides by the same rule
        write_rrd(
            views,
            recordings,
            models[:shown],
            labels[:shown],
            findings,
            comparisons=comparisons[:shown],
            names=ROLES[:shown],
            force=True,
        )
    _chapter("6", "Look at it", f"{time.perf_counter() - begin:.0f} s")
    for note in notes:
        say(f"  {note}")
    console.print(f"  {page}   the report: models and recordings compared; open it in any browser")
    console.print(f"  {views}   the same as rerun views, with the turning gear train: .venv/bin/rerun {views}")
    console.print(f"  {rrd}   the live run: .venv/bin/rerun {rrd}")
    console.print(f"  {output / 'live'}   MCAP of all topics, for Foxglove, PlotJuggler or ros2 bag")
    console.print(f"  {better_file}   the model with the effects found; {fitted_file}: the same, all parameters fitted")
    console.print("\nNow your own machine, from its CSVs (docs/tutorial_own_recordings.md):")
    console.print("  .venv/bin/ema-twin init YOUR_*.csv -o mine --torque-constant N_M_PER_A")
    console.print("  .venv/bin/ema-twin discover YOUR_*.csv --map mine_map.yaml --model mine.yaml -o found.yaml")
    console.print("Traces of the Torino bench itself need no init: discover TRACES --model polito_bench -o found.yaml")
    if not why_not_shown():
        start_viewer(str(rrd))


def _prepare(output: Path) -> None:
    """Make the folder, or remove an earlier demo's live run from it; refuse any other folder that is not empty."""
    import shutil

    try:
        if output.is_dir() and any(output.iterdir()) and not (output / MARKER).is_file():
            raise InputError(f"{output}: is not a demo's folder (it has no {MARKER}); choose another folder with -o")
        output.mkdir(parents=True, exist_ok=True)
        (output / MARKER).write_text("The next ema-twin demo replaces what is in this folder.\n")
        shutil.rmtree(output / "live", ignore_errors=True)
    except OSError as error:
        raise InputError(f"{output}: cannot be written ({error.strerror}); choose a folder you may write to") from None


def switched_off(start: Model, found: Model) -> Model:
    """The start model with the found effects added but disabled, to be switched on in the running twin."""
    new = {name: replace(held, enabled=False) for name, held in found.effects.items() if name not in start.effects}
    return replace(start, effects={**start.effects, **new})


def _most_telling_first(found: Discovery) -> list[str]:
    """Names of the found effects, in the order in which the verdict lists them."""
    return sorted(found.parameters, key=lambda name: found.added.index(found.parameters[name]["effect"]))


def moments_of(names: Sequence[str], duration: float) -> dict[str, float]:
    """Time [s of the replay] at which each effect is switched on: one after another, evenly spaced."""
    pause = max(1, round(duration / (len(names) + 1)))
    return {name: float(pause * (k + 1)) for k, name in enumerate(names)}


def _chapter(number: str, title: str, detail: str) -> None:
    console.print(f"\n[bold cyan]{number}. {title}[/bold cyan]  [dim]{detail}[/dim]\n", soft_wrap=True)
