"""``ema-twin sweep``: simulate and search many models: which effects can be found, and from which size on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from ..listing import number_of
from . import options
from .output import console, counted, say, status, warn
from .tables import ReportTable

if TYPE_CHECKING:
    from ..campaign.sweep_points import SweptPoint

EXAMPLES = """Examples:

ema-twin sweep --model polito_bench --vary backlash.width=0.0001:0.002:6:log -c triangle:0.1:1 -o play --repeats 5

ema-twin sweep --model polito_bench --vary coulomb_friction.torque=0.03:0.12:5 \
--vary viscous_friction.coefficient=0.01:0.05:5 -c ramp:0.05 --bounds-only -o friction --page friction.html

ema-twin sweep --model press.yaml --vary stribeck_friction.torque=0:0.1:2 --vary stribeck_friction.speed=0.5:5:2 \
--sample 200 -c sine:0.05:0.25 -o stribeck

If the model lacks the effect of a varied parameter, the effect is simulated and the search has to find it. If the \
parameter or constant is the model's own, only the simulated machine has the varied value."""

_SHOWN = 5
"""Number of refused or failed points whose reason is printed."""


def run(
    model: options.ModelName,
    vary: Annotated[
        list[str],
        typer.Option(
            metavar="PATH=LOW:HIGH:COUNT[:log]",
            help="A parameter to vary and its values, in SI units; PATH=VALUE for one value. May be repeated.",
        ),
    ],
    command: Annotated[
        list[str],
        typer.Option(
            "--command", "-c", metavar="KIND:A:B", help="The command for the bench, as for simulate. Repeatable."
        ),
    ],
    output: options.Results,
    seconds: Annotated[
        float, typer.Option(metavar="S", parser=options.number(0.1, 1e4, "s"), help="Duration of each recording.")
    ] = 20.0,
    sample: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            parser=options.whole(1, 1_000_000),
            help="N points drawn evenly (Latin hypercube), in place of a grid.",
        ),
    ] = None,
    repeats: Annotated[
        int,
        typer.Option(
            metavar="N", parser=options.whole(1, 1_000_000), help="Simulations per point, each with different noise."
        ),
    ] = 1,
    seed: Annotated[int, typer.Option(metavar="N", parser=options.whole(0, 10**9), help="Seed of the sample.")] = 0,
    bounds_only: Annotated[
        bool, typer.Option("--bounds-only", help="Compute only the bounds of the errors, without searching (faster).")
    ] = False,
    workers: options.Workers = options.CORES,
    scheduler: options.Scheduler = None,
    page: Annotated[
        Path | None, typer.Option(metavar="FILE.html", help="Also write an HTML page with a map of the results.")
    ] = None,
    force: options.Force = False,
    json: options.JsonFile = None,
) -> None:
    """Simulate many models and search each of them: from which size is an effect found, and how accurately?

    The Cramér-Rao bound is the smallest standard error that any method can reach with these recordings.
    """
    from ema_bench_replay.errors import InputError

    from ..campaign.engine import cluster
    from ..campaign.results import DONE, FAILED
    from ..campaign.store import Store
    from ..campaign.sweep import VERB, Study, Varied, grid, with_settings
    from ..campaign.sweep import sample as sampled
    from ..campaign.sweep import sweep as points_swept
    from ..campaign.sweep_points import detection_limit, swept_points
    from ..model import load_model
    from ..model.model_file import model_files
    from ..simulation.command import parse_command
    from ..words.sweep import limit_words
    from .inputs import check_outputs, write_json

    check_outputs([], force, page=page)
    base = load_model(model)
    for text in command:
        parse_command(text)
    varied = [Varied.of(text) for text in vary]
    if twice := {one.path for one in varied if sum(one.path == other.path for other in varied) > 1}:
        raise InputError(f"--vary {min(twice)}: is given twice; give each parameter once")
    for values in zip(*((one.low, one.high) for one in varied), strict=True):
        with_settings(base, [(one.path, value) for one, value in zip(varied, values, strict=True)])
    study = Study(str(model_files(model)[0].resolve()), tuple(command), seconds, not bounds_only)
    points = grid(varied, study, repeats) if sample is None else sampled(varied, study, sample, seed, repeats)
    store = Store.made(output)
    settled = store.settled()
    waiting = [point for point in points if point.key not in settled]
    if len(waiting) < len(points):
        say(f"{len(points) - len(waiting)} of {len(points)} already have results and are skipped.")
    statuses: Counter[str] = Counter()
    if waiting:
        with ExitStack() as stack:
            with status() as progress:
                progress("starting the workers")
                client = stack.enter_context(cluster(scheduler, min(workers, len(waiting))))
            done = stack.enter_context(counted(len(waiting), "simulating"))
            for outcome in points_swept(client, waiting, study, store.folder.resolve()):
                statuses[outcome.status] += 1
                if outcome.status != DONE and statuses.total() - statuses[DONE] <= _SHOWN:
                    warn(f"{outcome.job.name}: {outcome.status}: {outcome.message}")
                done(outcome.job.name)
    store.merge_files()
    keys = {point.key for point in points}
    rows = [row for row in store.rows() if row["task"] == VERB]
    asked = [row for row in rows if row["key"] in keys]
    lost = sum(row["status"] != DONE for row in asked)
    if lost:
        say(f"{len(asked) - lost} of {len(asked)} points were done; {lost} were refused or failed.")
    if len(asked) < len(rows):
        say(
            f"{output} holds {len(rows) - len(asked)} results of other sweeps, which are not shown; run their commands "
            "again to see them."
        )
    found = swept_points(asked)
    _show(found)
    limit = detection_limit(found)
    if limit is not None:
        say(limit_words(limit))
    if page is not None:
        from ..report.sweep_page import write_sweep_page

        ratios = frozenset(one.path for one in varied if one.logarithmic)
        say(f"{write_sweep_page(page, found, limit, lost=lost, ratios=ratios, force=force)}: open it in any browser")
    write_json(json, [point.as_json() for point in found])
    statuses = statuses or Counter(row["status"] for row in asked)
    if not statuses[DONE]:  # 2 as with any command whose input is refused
        raise typer.Exit(1 if statuses[FAILED] else 2)


def _show(points: Sequence[SweptPoint]) -> None:
    """Print one row per point: how often the effect was named, and the errors of the varied numbers."""
    from ..words.sweep import columns, meaning, point_cells

    if not points:
        return
    table = ReportTable(number_of(len(points), "point"))
    paths = [path for path, _, _ in points[0].settings]
    told = columns(points)
    table.numbers(*(escape(path) for path in paths), *told)
    for point in points:
        table.add_row(*point_cells(point, told))
    console.print(table)
    say(meaning(points))
