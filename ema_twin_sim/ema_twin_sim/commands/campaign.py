"""``ema-twin campaign``: judge hundreds of recordings of many units in parallel, resumably, into one store."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from ema_bench_replay.errors import InputError

from . import options
from .output import COMMAND, counted, say, status, warn

if TYPE_CHECKING:
    from distributed import Client

    from ..campaign.engine import Outcome
    from ..campaign.jobs import Grouping, Job, Task
    from ..campaign.store import Store

EXAMPLES = """Examples:

ema-twin campaign recordings --model polito_bench -o results     (recordings/UNIT/…: what each unit's model lacks)

ema-twin campaign tests --model press.yaml --map press -o results --do fit --unit "(?P<unit>EMA\\d+)_(?P<time>[\\d-]+)"

ema-twin campaign tests --model press.yaml -o results --watch     (also judges recordings that arrive later)

ema-twin campaign rig --do health --map rig.yaml --wavelength 0.005 -o results     (no model; the lead is 5 mm)

ema-twin campaign /data/tests --model /data/press.yaml -o /data/results --scheduler tcp://10.0.0.1:8786

Then: ema-twin units results"""

_SHOWN = 5
"""Number of refused (and of failed) recordings whose reason is printed, and of damaged ones whose damage is."""
_EVERY = 10.0  # s, interval of the search for new recordings


def _verbs(incomplete: str) -> list[str]:
    from ..campaign.jobs import VERBS

    return [verb for verb in VERBS if verb.startswith(incomplete)]


def _together(incomplete: str) -> list[str]:
    from ..campaign.jobs import TOGETHER

    return [what for what in TOGETHER if what.startswith(incomplete)]


def run(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder that holds the units' recordings.")],
    output: options.Results,
    model: Annotated[
        str | None,
        typer.Option(
            "--model",
            "-m",
            help="Model file, or a name in config/models; health needs none.",
            autocompletion=options.model_names,
        ),
    ] = None,
    do: Annotated[
        str,
        typer.Option(
            metavar="VERB",
            help="What to do: compare, fit, diagnose or discover; or health (compare each recording with the unit's "
            "own healthy ones).",
            autocompletion=_verbs,
        ),
    ] = "discover",
    unit: Annotated[
        str | None,
        typer.Option(
            metavar="PATTERN",
            help="Regular expression for a recording's path with (?P<unit>...) and, optionally, (?P<time>...) and "
            "(?P<test>...). By default a unit is a folder in FOLDER, and a test a folder in that.",
        ),
    ] = None,
    together: Annotated[
        str,
        typer.Option(
            metavar="WHAT",
            help="What to judge together: recording (each alone), folder (all in a folder) or unit (all of a unit).",
            autocompletion=_together,
        ),
    ] = "recording",
    import_map: options.ImportMap = "siemens",
    without: options.Without = None,
    wavelength: Annotated[
        float | None,
        typer.Option(
            metavar="M|RAD",
            parser=options.number(1e-9, options.LARGEST, "m or rad"),
            help="With --do health: travel after which the machine repeats, such as the lead of a screw; by default "
            "one turn of a rotary machine's motor, if the motor's angle, both encoders or --model show it.",
        ),
    ] = None,
    workers: options.Workers = options.CORES,
    scheduler: options.Scheduler = None,
    watch: Annotated[bool, typer.Option("--watch", help="Keep judging new recordings, until Ctrl-C.")] = False,
) -> None:
    """Judge every recording of many units, on all cores or a cluster. A recording that has a result is skipped.

    An interrupted campaign continues where it stopped. A recording that cannot be judged is reported, and the others go
    on. RESULTS holds Parquet files, which pandas, polars and DuckDB can read.
    """
    from ema_bench_replay.configuration import find_configuration

    from ..campaign.engine import cluster
    from ..campaign.jobs import APART, HEALTH, SEARCHING, VERBS, Grouping, Task
    from ..campaign.store import Store
    from ..effects import find_effect
    from ..model import load_model
    from ..model.model_file import model_files

    if do not in VERBS:
        raise InputError(f"--do {do}: unknown; choose {', '.join(VERBS[:-1])} or {VERBS[-1]}")
    if model is not None:
        load_model(model)
    elif do != HEALTH:
        raise InputError(f"--do {do}: needs a model; give one with --model, or --do {HEALTH}")
    if wavelength is not None and do != HEALTH:
        raise InputError(f"--wavelength {wavelength:g}: {do} needs none; leave it out, or give --do {HEALTH}")
    if without and do not in SEARCHING:
        raise InputError(f"--without {without[0]}: {do} looks for no effects; leave it out, or give --do discover")
    if do == HEALTH and together != APART:
        raise InputError(f"--together {together}: health judges each recording alone; leave --together out")
    task = Task(
        do,
        "" if model is None else str(model_files(model)[0].resolve()),
        str(find_configuration("maps", import_map).resolve()),
        tuple(find_effect(id, "--without").id for id in without or ()),
        wavelength,
    )
    grouping = Grouping.of(folder.resolve(), unit, together)
    store = Store.made(output)
    tell = cache(warn)  # of what is said at each look, the first time alone
    try:
        first = _waiting(grouping, task, store, set(), tell)
    except InputError as error:  # the folder is still empty, or a file's name does not fit
        if not watch:
            raise
        tell(str(error))
        first = []
    counts: Counter[str] = Counter()
    if first or watch:
        with ExitStack() as stack:
            with status() as progress:
                progress("starting the workers")
                client = stack.enter_context(cluster(scheduler, workers if watch else min(workers, len(first))))
            for jobs in _rounds(first, grouping, task, store, tell, watch=watch):
                counts += _judge(client, jobs, task, store)
    store.merge_files()
    _tell(counts, output)
    if counts["refused"] and counts["refused"] == counts.total():
        raise typer.Exit(2)  # nothing was judged, as with any command whose input is refused
    if counts["failed"] and not counts["done"]:
        raise typer.Exit(1)


def _waiting(grouping: Grouping, task: Task, store: Store, known: set[str], tell: Callable[[str], None]) -> list[Job]:
    """Jobs that have no result yet and are not in ``known``."""
    from ..campaign.jobs import find_jobs

    jobs = find_jobs(grouping, task, (store.folder,), tell)
    settled = store.settled()
    waiting = [job for job in jobs if job.key not in settled and job.key not in known]
    if len(waiting) < len(jobs) and not known:
        say(f"{len(jobs) - len(waiting)} of {len(jobs)} already have results and are skipped.")
    return waiting


def _rounds(
    first: Sequence[Job], grouping: Grouping, task: Task, store: Store, tell: Callable[[str], None], *, watch: bool
) -> Iterator[Sequence[Job]]:
    """Yield the jobs found now and, with ``watch``, those that come later, once their files have stopped growing."""
    tried = {job.key for job in first}
    if first:
        yield first
    growing: set[str] = set()
    while watch:
        if not growing:
            say("Waiting for recordings; Ctrl-C ends it.")
        time.sleep(_EVERY)
        try:
            jobs = _waiting(grouping, task, store, tried, tell)
        except FileNotFoundError:  # renamed or removed while the folder was read; what it is now is found next time
            continue
        except InputError as error:  # for example a file's name that does not fit, which its owner may correct
            tell(str(error))
            continue
        ready = [job for job in jobs if job.key in growing]
        growing = {job.key for job in jobs} - {job.key for job in ready}
        tried |= {job.key for job in ready}
        if ready:
            yield ready


def _judge(client: Client, jobs: Sequence[Job], task: Task, store: Store) -> Counter[str]:
    from ..campaign.campaign import campaign

    counts: Counter[str] = Counter()
    damaged = 0
    told: set[str] = set()  # what many recordings have in common is told of the first
    with counted(len(jobs), "judging") as done:
        outcomes: Iterator[Outcome] = campaign(client, jobs, task, store.folder.resolve())
        for outcome in outcomes:
            counts[outcome.status] += 1
            if outcome.status != "done" and counts[outcome.status] <= _SHOWN:
                warn(f"{outcome.job.unit}, {outcome.job.name}: {outcome.status}: {outcome.message}")
            new = [warning for warning in outcome.warnings if warning not in told]
            told.update(new)
            damaged += bool(new)
            for warning in new if damaged <= _SHOWN else ():
                warn(f"{outcome.job.unit}: {warning}")
            done(outcome.job.name)
    if hidden := sum(max(0, counts[what] - _SHOWN) for what in ("refused", "failed")):
        warn(f"{hidden} more have no result; ema-twin units {quote(str(store.folder))} --unit UNIT tells why")
    if damaged > _SHOWN:
        warn(f"{damaged - _SHOWN} more recordings have such warnings; the results hold them (column warnings)")
    return counts


def _tell(counts: Counter[str], output: Path) -> None:
    if counts:
        refused, failed = counts["refused"], counts["failed"]
        told = [f"{counts['done']} judged"]
        told += [f"{refused} refused"] if refused else []
        told += [f"{failed} failed; run the command again to retry them"] if failed else []
        say(f"{', '.join(told)}.")
    else:
        say("Nothing is left to do.")
    say(f"Results are in {output}. To list the units:")
    say(f"{COMMAND}units {quote(str(output))}")
