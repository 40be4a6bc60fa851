"""``ema-twin live``: replay, twin and monitor together as ROS nodes, with rerun."""

from __future__ import annotations

import os
import threading
from contextlib import ExitStack
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer

from ema_bench_replay.errors import InputError

from . import options
from .output import console, say, takes_colours, unfolded, warn

EXAMPLES = """Examples:

ema-twin live recordings/BancoEMA_sine_0.02_1Hz --model polito_bench

ema-twin live run.mcap --model better.yaml --rate 5 --headless --json live.json

ema-twin live run.mcap --model polito_bench --loop --web -o better.yaml     (d: missing?  a: add  q: end)

ema-twin live --model polito_bench --record bench --max-bag-duration 600     (a file every ten minutes)

ema-twin live --model polito_bench     (attaches to a running /bench/state: the real bench)

ema-twin live --model polito_bench --results results --unit EMA-07 --healthy "test 0[0-7]"     (its health)"""


def run(
    run: Annotated[
        Path | None, typer.Argument(metavar="RUN", help="A recording to replay; without it, the running bench.")
    ] = None,
    model: options.ModelName = "polito_bench",
    input: options.Input = None,
    rate: options.Rate = 1.0,
    loop: Annotated[bool, typer.Option("--loop", help="Repeat the recording until q or Ctrl-C.")] = False,
    headless: Annotated[bool, typer.Option("--headless", help="No viewer.")] = False,
    web: Annotated[bool, typer.Option("--web", help="The viewer in a browser, served on this machine only.")] = False,
    rrd: Annotated[Path | None, typer.Option(metavar="FILE", help="Write a rerun recording.")] = None,
    record: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Record all topics to an MCAP in a new folder.")
    ] = None,
    max_bag_size: Annotated[
        float | None, options.bounded("BYTES", 1.0, 1e18, "bytes", "With --record: start a new file at this size.")
    ] = None,
    max_bag_duration: Annotated[
        float | None,
        options.bounded("S", 0.1, options.LARGEST, "s", "With --record: start a new file after this time."),
    ] = None,
    results: Annotated[
        Path | None,
        typer.Option(
            metavar="RESULTS",
            help="Judge the running unit against its healthy recordings; RESULTS is the folder that campaign --do "
            "health wrote.",
        ),
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="With --results: the running unit; required if they hold several."),
    ] = None,
    healthy: Annotated[
        str | None,
        typer.Option(
            metavar="N|PATTERN",
            help="With --results: which of its recordings are healthy (same syntax as units --healthy); by default "
            "the first third.",
        ),
    ] = None,
    judged_after: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            parser=options.number(1.0, 3600.0, "s"),
            help="With --results: judge a continuing run every S seconds by its last S seconds; 60 by default.",
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="MODEL", help="Write the twin's final model.")
    ] = None,
    with_files: options.WithFiles = None,
    import_map: options.ImportMap = "siemens",
    start: options.From = None,
    end: options.To = None,
    strict: options.Strict = False,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Replay a recording with twin and monitor as ROS 2 nodes, in real time, until every sample is compared.

    The nodes publish /bench/state, /twin/state, /monitor/residual and /monitor/health; the final errors are those that
    compare gives for the same recording and model. With --results they also judge the unit's health. Keys on a
    terminal: d diagnoses which effect the model lacks so far, a adds the effects found to the running twin, q quits.
    """
    from ema_bench_replay.recording import refuse_points

    from ..live.live_model import live_model
    from ..measured.noise import noise_of
    from ..measured.quieter_motion import as_measured
    from ..model import save_model
    from ..nodes.live import run_live
    from ..nodes.live_session import HealthAsked
    from ..own_effects import load_effects
    from ..simulation.behind_motor import refuse_encoders_alone
    from ..simulation.compared_signals import noise_floors
    from ..simulation.dc_link_check import refuse_recording_beyond_link
    from ..simulation.simulate import choose_input
    from .inputs import check_outputs, check_rrd_name, input_files, load_runs, refuse_inputs, write_json
    from .live_error import LINES_ARE, ErrorPrinter
    from .live_keys import Keys
    from .live_view import open_view
    from .shown_live import as_json, show

    bag = None if record is None else record / f"{record.name}.mcap"
    inputs = input_files([run] if run is not None else [], [model], import_map, with_files)
    refuse_inputs(inputs, json, rrd, bag, output, folder=record)
    check_rrd_name(rrd)
    check_outputs([], force, model=output)
    load_effects(with_files or ())
    found = live_model(model)
    recording = None
    if run is not None:
        recordings = load_runs([run], import_map=import_map, start=start, end=end, strict=strict, least=2)
        if len(recordings) != 1:
            raise InputError(f"{run}: holds {len(recordings)} recordings; live plays one, name it")
        refuse_points(recordings[0])
        refuse_encoders_alone(recordings[0])
        recording = as_measured(recordings, found)[0]
    driving = choose_input(recording, found, input) if recording is not None else input
    if recording is not None and driving is not None:
        refuse_recording_beyond_link(found, recording, driving)
    if record is None and (max_bag_size is not None or max_bag_duration is not None):
        raise InputError("--max-bag-size and --max-bag-duration need --record; give --record DIR")
    if results is None and (unit, healthy, judged_after) != (None, None, None):
        raise InputError("--unit, --healthy and --judged-after need --results; give --results RESULTS")
    watched = None if results is None else HealthAsked(results, unit or "", healthy or "", judged_after)
    replaced = _check_outputs(rrd, record, force)
    if recording is None:
        console.print("Waiting for /bench/state; Ctrl-C ends.", style="dim")
    noise = noise_floors(found) if recording is None else noise_of([recording], found)
    say(LINES_ARE)
    printer = ErrorPrinter(noise, recording)
    stop = threading.Event()
    if not takes_colours():
        os.environ.setdefault("RCUTILS_COLORIZED_OUTPUT", "0")  # of the nodes' log
    with ExitStack() as held:
        browser = None
        if web:
            from ..views.web_viewer import WebViewer

            browser = WebViewer()
            held.callback(browser.close)
            say(f"Open {browser.page}")
        view = open_view(rrd, headless, browser, noise, found)
        if view is not None:
            held.callback(view.close)
            printer.watchers.append(view.take)
        with Keys(stop, view, output) as keys:
            result = run_live(
                recording,
                found,
                input=input or "auto",
                rate=rate,
                loop=loop,
                on_pairs=printer.take,
                notify=lambda text: unfolded(f"  {text}"),
                on_start=keys.begin,
                record_to=record,
                max_bag_size=round(max_bag_size or 0.0),
                max_bag_duration=max_bag_duration or 0.0,
                health=watched,
                replaced=replaced,
                stop=stop,
            )
        # before the views are closed, so that neither a failing viewer nor a full disk costs the result of the run
        show(result, 0.0 if loop or stop.is_set() else rate, loop=loop)
        write_json(json, as_json(result))
        if output is not None and result.twin is not None:
            save_model(result.twin, output, force=force)
            shown = f"ema-twin diff {quote(model)} {quote(str(output))}"
            say(f"{output} is the twin's final model; {shown} shows the changes.")
        for warning in result.warnings:
            warn(warning)
    if rrd is not None:
        from .rerun_file import tell_of_rrd

        tell_of_rrd(rrd, ("the live run",))
    if result.unrecorded:
        raise InputError(f"{record}: the recording is incomplete: {result.unrecorded}")
    if loop or recording is None or stop.is_set():  # such a run has no end of its own
        return
    if result.interrupted:
        raise KeyboardInterrupt
    if not result.complete:
        counts = ", ".join(f"{name} {count}" for name, count in result.counts.items())
        raise InputError(f"{result.name}: not every sample was compared ({counts}); play it slower (--rate)")


def _check_outputs(rrd: Path | None, record: Path | None, force: bool) -> list[Path]:
    """Refuse outputs that may not be replaced, before anything starts; return the bag files that ``force`` replaces."""
    from ema_bench_replay.bags.bag_parts import named_after

    if rrd is not None and rrd.exists():
        if not rrd.is_file():
            raise InputError(f"{rrd}: is no file; name the file to write for --rrd")
        if not force:
            raise InputError(f"{rrd}: exists already; choose another name or give --force")
    if record is None or not record.exists():
        return []
    if not record.is_dir():
        raise InputError(f"{record}: is no folder; name the folder to make for --record")
    held = sorted(record.iterdir())
    bags = [file for file in named_after(record) if file.is_file()]
    own = [*bags, record / "metadata.yaml"] if bags else []
    others = [path.name for path in held if path not in own or not path.is_file()]
    if others:
        more = f" and {len(others) - 3} more" if len(others) > 3 else ""
        raise InputError(
            f"{record}: holds {', '.join(others[:3])}{more}, which --record did not write; choose another folder"
        )
    if held and not force:
        raise InputError(f"{record}: holds a bag already; choose another folder or give --force")
    return held
