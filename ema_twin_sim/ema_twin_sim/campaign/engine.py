"""The engine: jobs in batches over the workers of a dask cluster, fed as it goes.

A cluster's task costs milliseconds, and its whole graph is looked at before the first one starts: so jobs go in
batches of a second's work or more, a few for every worker, and the next batch when one is done. What a batch finds, its
worker writes to the store: the campaign hears only how it went, and may end at any moment.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

from ema_bench_replay.errors import InputError

if TYPE_CHECKING:
    from distributed import Client, Future

    from .jobs import Job

BATCH = 1.0
"""Seconds of work in a batch at least: a hundred times what a task costs."""
TASK = 0.01
"""Seconds that scheduler and client together may have for a batch: with more workers, batches last longer, so that one
scheduler keeps up."""
AHEAD = 2
"""Batches for every thread of a worker: one that it works on, one that waits for it."""
LARGEST = 1000
"""Jobs in a batch at most."""
DEATHS = 1
"""Workers that may die over a batch before its jobs are doubted. What died with them may be no fault of theirs, since a
worker that dies takes all with it that waits for it: so each is tried once more, with nothing beside it.
"""
SPARING = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
"""What each process of a cluster would otherwise watch of itself all the time, for pages that nobody opens: 2.6 % of a
core a worker and 1.1 % the scheduler; with these it is 0.5 % and 0.3 %."""
_CONNECTING = 5.0  # s, to a worker that may have died, or to a scheduler
_LISTENING = "127.0.0.1"


class Outcome(NamedTuple):
    """How a job went: what its row says, without what was found."""

    job: Job
    status: str
    message: str
    seconds: float


Work = Callable[[Sequence["Job"]], list[Outcome]]
"""Done by a worker: the outcome of every job of a batch, all of which are in the store."""


@contextmanager
def cluster(scheduler: str | None, workers: int) -> Iterator[Client]:
    """A client of the ``scheduler`` at an address, or of one of its own with so many worker processes.

    One of its own listens on this machine only, and to this campaign only: what is sent is sealed with keys that last
    as long as it does. Raises InputError where no scheduler answers.
    """
    import dask
    from distributed import Client, LocalCluster
    from distributed.security import Security

    settings = {
        **SPARING,
        "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.comm.timeouts.connect": _CONNECTING,
        "distributed.scheduler.http.routes": [],  # no pages of its own, which would be open to the whole machine
        "distributed.worker.http.routes": [],
        "logging": {"distributed": "critical", "asyncio": "critical", "tornado": "critical"},
    }
    with dask.config.set(settings):
        _quieten()
        if scheduler is not None:
            try:
                client = Client(scheduler, timeout=_CONNECTING)
            except (OSError, ValueError, TypeError) as error:
                raise InputError(
                    f"--scheduler {scheduler}: does not answer ({' '.join(str(error).split()) or 'no such address'}); "
                    "start one with: dask scheduler --host ADDRESS"
                ) from None
            with client:
                yield client
            return
        with (
            LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                host=_LISTENING,
                dashboard_address=None,
                scheduler_kwargs={"dashboard_address": f"{_LISTENING}:0"},  # a free port, beside other campaigns
                security=Security.temporary(),
                protocol="tls",
            ) as local,
            Client(local) as client,
        ):
            yield client


def run(client: Client, jobs: Iterable[Job], work: Work, lost: Callable[[Job, str], Outcome]) -> Iterator[Outcome]:
    """The outcomes of all jobs, as they come.

    A job over which workers die with nothing beside it is given up: ``lost`` writes what is known of it. Raises
    InputError where the scheduler is lost; what was done is in the store then.
    """
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    waiting = iter(jobs)
    doubted: list[Job] = []  # of batches that workers died over
    held: dict[Future[Any], list[Job]] = {}
    done = as_completed(loop=client.loop)
    seconds: float | None = None  # that a job takes, in the mean of late

    def feed() -> None:
        threads = max(sum(client.nthreads().values()), 1)
        batch_time = max(BATCH, TASK * threads)
        size = 1 if seconds is None else min(max(round(batch_time / max(seconds, batch_time / LARGEST)), 1), LARGEST)
        while len(held) < AHEAD * threads and (batch := list(islice(waiting, size))):
            give(batch)
        if not held and doubted:
            give([doubted.pop()])

    def give(batch: list[Job]) -> None:
        future = client.submit(work, batch, pure=False)
        held[future] = batch
        done.add(future)

    with _scheduler_lost():
        feed()
    while held:
        was_alone = len(held) == 1 and len(next(iter(held.values()))) == 1
        future = next(done)
        batch = held.pop(future)
        try:
            with _scheduler_lost():
                outcomes = future.result()
        except KilledWorker:
            if was_alone:
                outcomes = [lost(batch[0], f"{DEATHS + 1} workers died over it")]
            else:
                doubted += batch
                outcomes = []
        took = [outcome.seconds for outcome in outcomes]
        if took:
            mean = sum(took) / len(took)
            seconds = mean if seconds is None else 0.5 * (seconds + mean)
        future.release()
        yield from outcomes
        with _scheduler_lost():
            feed()


@contextmanager
def _scheduler_lost() -> Iterator[None]:
    """Turn what a client says in one way or another where its scheduler is no more into InputError."""
    from distributed.client import FutureCancelledError
    from distributed.comm import CommClosedError

    try:
        yield
    except (FutureCancelledError, CommClosedError, TimeoutError):
        raise InputError("the scheduler has ended; start the campaign again: finished results are kept") from None


def _quieten() -> None:
    """Keep the cluster's own log from what the user reads: what matters of it is told in a row."""
    import logging

    for name in [*logging.root.manager.loggerDict]:
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
