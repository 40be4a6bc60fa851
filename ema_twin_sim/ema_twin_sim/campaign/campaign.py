"""Run the jobs of a campaign on a cluster, and write their results to a store."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..parallel import one_after_another
from .engine import Outcome, run
from .jobs import Job, Task
from .results import DONE, FAILED, REFUSED
from .store import Store
from .work import Row, blank, judged

if TYPE_CHECKING:
    from distributed import Client

_ORDER = (FAILED, DONE, REFUSED)


def campaign(client: Client, jobs: Sequence[Job], task: Task, store: Path) -> Iterator[Outcome]:
    """Yield the outcomes of jobs as they finish; their rows are in the store."""
    yield from stored(client, jobs, store, partial(judged, task=task), partial(blank, verb=task.verb, model=task.model))


def stored(
    client: Client, jobs: Sequence[Job], store: Path, work: Callable[..., list[Row]], nothing: Callable[[Job], Row]
) -> Iterator[Outcome]:
    """Yield the outcomes of jobs as they finish; their rows are in the store.

    ``work`` makes a job's rows, and calls ``tell`` with warnings; ``nothing`` makes the row of a job that was lost.
    """
    yield from run(client, jobs, partial(_batch, work=work, store=store), partial(_lost, nothing=nothing, store=store))


def _batch(jobs: Sequence[Job], work: Callable[..., list[Row]], store: Path) -> list[Outcome]:
    one_after_another()  # the other cores have workers of their own
    told: list[list[str]] = [[] for _ in jobs]
    each = [work(job, tell=warnings.append) for job, warnings in zip(jobs, told, strict=True)]
    Store(store).write([row for rows in each for row in rows])
    return [outcome(job, rows, warnings) for job, rows, warnings in zip(jobs, each, told, strict=True)]


def outcome(job: Job, rows: Sequence[Row], warnings: Sequence[str] = ()) -> Outcome:
    """The outcome of a job with these rows: failed if any failed, else done if any is done, else refused."""
    worst = min(rows, key=lambda row: _ORDER.index(row["status"]))
    seconds = sum(row["seconds"] for row in rows)
    return Outcome(job, worst["status"], worst.get("message") or "", seconds, tuple(warnings))


def _lost(job: Job, reason: str, nothing: Callable[[Job], Row], store: Path) -> Outcome:
    Store(store).write([nothing(job) | {"status": FAILED, "message": reason}])
    return Outcome(job, FAILED, reason, 0.0)
