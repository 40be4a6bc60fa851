"""A campaign: all jobs of a folder that have no result yet, over a cluster, into a store."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..parallel import one_after_another
from .engine import Outcome, run
from .jobs import Job, Task
from .store import Store
from .work import judged, lost

if TYPE_CHECKING:
    from distributed import Client


def campaign(client: Client, jobs: Sequence[Job], task: Task, store: Path) -> Iterator[Outcome]:
    """The outcomes of jobs as they come; their rows are in the store."""
    yield from run(client, jobs, partial(_batch, task=task, store=store), partial(_lost, task=task, store=store))


def _batch(jobs: Sequence[Job], task: Task, store: Path) -> list[Outcome]:
    one_after_another()  # the other cores have workers of their own
    rows = [judged(job, task) for job in jobs]
    Store(store).write(rows)
    return [
        Outcome(job, row["status"], row.get("message") or "", row["seconds"])
        for job, row in zip(jobs, rows, strict=True)
    ]


def _lost(job: Job, reason: str, task: Task, store: Path) -> Outcome:
    row = lost(job, task, reason)
    Store(store).write([row])
    return Outcome(job, row["status"], reason, 0.0)
