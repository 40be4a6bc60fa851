"""The engine: run jobs in batches on the workers of a dask cluster, submitting more as batches finish.

A dask task costs milliseconds, and the whole graph is processed before the first task starts. So jobs go in batches of
one second's work or more, a few for every worker, and the next batch when one is done. The workers write their results
to the store; the campaign receives only the outcomes, and may end at any moment.
"""

from __future__ import annotations

import logging
import queue
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Any, NamedTuple

from ema_bench_replay.errors import InputError

from .lost_workers import LOOK, PATIENCE, LostWorkers

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

    from .jobs import Job

BATCH = 1.0
"""Minimum seconds of work in a batch: a hundred times what a task costs."""
TASK = 0.01
"""Seconds of scheduler and client time allowed per batch: with more workers, batches last longer, so that one scheduler
keeps up."""
AHEAD = 2
"""Batches per worker thread: one in progress, one waiting."""
LARGEST = 1000
"""Maximum number of jobs in a batch."""
DEATHS = 1
"""Number of workers that may die on a batch before its jobs are doubted. The batch may not be at fault, since a worker
that dies takes all batches with it that wait for it: so each doubted job is tried once more, alone.
"""
SPARING = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
"""Settings that switch off or slow down the self-monitoring of each process, made for pages that nobody opens. It would
take 2.6 % of a core per worker and 1.1 % for the scheduler; with these settings it takes 0.5 % and 0.3 %."""
_CONNECTING = 5.0  # s, time limit of a connection to a worker that may have died, or to a scheduler
_ENDING = 30.0  # s, time limit for ending the workers of this machine
_LISTENING = "127.0.0.1"


class Outcome(NamedTuple):
    """How a job went: what its rows say, without the findings; and what is wrong with the recordings themselves."""

    job: Job
    status: str
    message: str
    seconds: float
    warnings: tuple[str, ...] = ()


Work = Callable[[Sequence["Job"]], list[Outcome]]
"""Work of a worker: returns the outcome of every job of a batch, whose rows are in the store then."""


@contextmanager
def cluster(scheduler: str | None, workers: int) -> Iterator[Client]:
    """Yield a client of the ``scheduler`` at this address or, without one, of a local cluster of ``workers`` processes.

    A local cluster listens on this machine only, and to this campaign only: traffic is encrypted (TLS) with keys that
    last as long as the cluster. Raises InputError if no scheduler answers, or the workers do not start.
    """
    import dask
    from distributed import Client

    settings = {
        **SPARING,
        "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.comm.timeouts.connect": _CONNECTING,
        # dask gives a worker up for good if it is not back by then; on a busy machine its start takes 15 s and more
        "distributed.deploy.lost-worker-timeout": f"{PATIENCE} s",
        "distributed.scheduler.http.routes": [],  # no web pages: they would be open to everybody on this machine
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
        with _local(workers) as local, Client(local) as client:
            yield client


@contextmanager
def _local(workers: int) -> Iterator[LocalCluster]:
    """Yield a cluster of this machine; end it even if one of its processes does not end."""
    from distributed import LocalCluster
    from distributed.security import Security

    try:
        with _interrupts_for_this_process_alone():
            local = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                host=_LISTENING,
                dashboard_address=None,
                silence_logs=logging.CRITICAL,  # a worker's last heartbeat may find the scheduler gone: no error
                scheduler_kwargs={"dashboard_address": f"{_LISTENING}:0"},  # a free port: others may be running
                security=Security.temporary(),
                protocol="tls",
            )
    except RuntimeError as error:
        reason: BaseException = error
        while reason.__cause__ is not None:  # "failed to start" alone says nothing
            reason = reason.__cause__
        raise InputError(
            f"--workers {workers}: the worker processes do not start ({' '.join(str(reason).split())}); free memory, "
            "or give fewer --workers"
        ) from None
    try:
        yield local
    finally:
        with suppress(TimeoutError):  # what is left of it ends with this process
            local.close(timeout=_ENDING)
            local.__exit__(None, None, None)  # it is closed, and ends its thread


@contextmanager
def _interrupts_for_this_process_alone() -> Iterator[None]:
    """Let threads and processes that start meanwhile, and all that these start, not be interrupted.

    Ctrl-C reaches every process of a terminal. Workers end with their campaign, without tracebacks of their own.
    """
    resource_tracker.ensure_running()  # whoever starts it lets interrupts through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)  # a Ctrl-C of this time arrives now


def run(client: Client, jobs: Iterable[Job], work: Work, lost: Callable[[Job, str], Outcome]) -> Iterator[Outcome]:
    """Yield the outcomes of all jobs as they finish.

    A job is given up if workers die on it even when it runs alone: ``lost`` writes what is known of it. Raises
    InputError if the scheduler is lost, or all workers are and none comes; finished results are in the store then.
    """
    from distributed.scheduler import KilledWorker

    waiting = iter(jobs)
    doubted: list[Job] = []  # of batches on which workers died
    held: dict[Future[Any], list[Job]] = {}
    done: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
    lost_workers = LostWorkers(client)
    seconds: float | None = None  # per job: a running mean that favours the last batches

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
        future.add_done_callback(done.put)

    with _scheduler_lost():
        feed()
    while held:
        was_alone = len(held) == 1 and len(next(iter(held.values()))) == 1
        future = _next(done, lost_workers)
        batch = held.pop(future)
        try:
            with _scheduler_lost():
                outcomes = future.result()
        except KilledWorker:
            if was_alone:
                outcomes = [lost(batch[0], f"{DEATHS + 1} workers died on it")]
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


def _next(done: queue.SimpleQueue[Future[Any]], lost_workers: LostWorkers) -> Future[Any]:
    """The next batch that is done. Raises InputError if there is no worker to do any."""
    while True:
        lost_workers.look()
        with suppress(queue.Empty):
            return done.get(timeout=LOOK)


@contextmanager
def _scheduler_lost() -> Iterator[None]:
    """Turn the various errors of a client whose scheduler has ended into InputError."""
    from distributed.client import FutureCancelledError
    from distributed.comm import CommClosedError

    try:
        yield
    except (FutureCancelledError, CommClosedError, TimeoutError):
        raise InputError("the scheduler has ended; start the campaign again: finished results are kept") from None


def _quieten() -> None:
    """Keep the cluster's own log away from the user: what matters of it is in a result row."""
    for name in [*logging.root.manager.loggerDict]:
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
