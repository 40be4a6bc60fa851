"""A dask cluster in processes of its own, as on a cluster: each can be killed, or asked what it took."""

import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager
from typing import NamedTuple

from ema_twin_sim.campaign.engine import SPARING, Outcome
from ema_twin_sim.campaign.results import DONE, FAILED

ENVIRONMENT = os.environ | {
    f"DASK_{name.upper().replace('.', '__').replace('-', '_')}": str(value) for name, value in SPARING.items()
}
"""Tells a cluster of others' making what a campaign tells its own."""


def no_work(jobs):
    """The outcomes of jobs that take no time. Workers and schedulers import this module."""
    return [Outcome(job, DONE, "", 1e-6) for job in jobs]


def second_of_no_work(jobs):
    """The same, but each says that it took a second: none goes together with others then."""
    return [Outcome(job, DONE, "", 1.0) for job in jobs]


def lost(job, reason):
    """The outcome of a job that was given up."""
    return Outcome(job, FAILED, reason, 0.0)


class Cluster(NamedTuple):
    """Its scheduler's address, and its processes."""

    address: str
    scheduler: subprocess.Popen
    workers: list[subprocess.Popen]


@contextmanager
def own_cluster(folder, workers=1):
    """A scheduler and workers of one thread each that listen on this machine; their files are in ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "scheduler.json"
    scheduler = _dask("scheduler", "--host", "127.0.0.1", "--port", 0, "--no-dashboard", "--scheduler-file", file)
    found = Cluster("", scheduler, [])
    try:
        begun = time.monotonic()
        while not (file.exists() and file.stat().st_size):  # it is there before it is written
            assert time.monotonic() - begun < 120.0
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        found = Cluster(address, scheduler, [])
        here = ("--host", "127.0.0.1", "--nthreads", 1, "--no-nanny", "--no-dashboard", "--local-directory", folder)
        for _ in range(workers):
            found.workers.append(_dask("worker", address, *here))
        yield found
    finally:
        for process in (*found.workers, scheduler):
            process.kill()
            process.wait()


def _dask(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *map(str, arguments)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
        env=ENVIRONMENT,
    )  # fmt: skip
