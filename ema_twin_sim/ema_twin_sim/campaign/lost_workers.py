"""Watch over the number of workers: start new ones in place of those that are gone for good, or end the campaign.

A worker that dies is started again by the process that looks after it (dask's nanny). But dask gives a worker up for
good, and starts no other, if its successor takes too long (as on a busy machine), if it fails to start, or if it loses
its connection to the scheduler. Batches then wait for workers that never come.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from ema_bench_replay.errors import InputError

if TYPE_CHECKING:
    from distributed import Client

LOOK = 1.0
"""Interval in s at which workers are counted."""
PATIENCE = 600.0
"""Time in s without any worker after which a campaign ends: 100 times what a worker takes to start on an idle machine.
"""
_TOLD_AFTER = 10.0  # s without any worker
_ANSWERED = 5.0  # s, within which a scheduler tells its workers


class LostWorkers:
    """Looks after the workers of a client's cluster. A local cluster gets new ones; others are told to their user."""

    def __init__(self, client: Client, clock: Callable[[], float] = time.monotonic) -> None:
        self._client: Any = client  # dask's annotations allow for one that is not connected
        self._local: Any = client.cluster  # None if others started the scheduler
        self._clock = clock
        self._looked = self._seen = clock()
        self._told = False

    def look(self) -> None:
        """Count the workers, once in LOOK, and replace those of a local cluster that will not come back.

        Raises InputError if there has been none for PATIENCE.
        """
        now = self._clock()
        if now - self._looked < LOOK:
            return
        self._looked = now
        number = self._number()
        if self._local is not None and (number or 0) < len(self._local.worker_spec):
            self._client.loop.add_callback(_replace, self._local)
        if number:
            self._seen, self._told = now, False
        elif now - self._seen >= PATIENCE:
            raise InputError(
                f"{self._trouble(number)} for {PATIENCE / 60.0:.0f} min; {self._remedy(number)}, and run the command "
                "again: finished results are kept"
            )
        elif now - self._seen >= _TOLD_AFTER and not self._told:
            self._told = True
            logging.getLogger(__name__).warning(
                "warning: %s for %.0f s; waiting %.0f min at most%s",
                self._trouble(number), now - self._seen, PATIENCE / 60.0,
                "" if self._local is not None else f"; {self._remedy(number)}",
            )  # fmt: skip

    def _number(self) -> int | None:
        """Number of workers; None if the scheduler does not answer, as the client will notice if it has ended."""
        with suppress(OSError):  # also a time-out, and a closed connection
            return len(self._client.sync(self._client.scheduler.ncores, callback_timeout=_ANSWERED))
        return None

    def _trouble(self, number: int | None) -> str:
        if self._local is not None:
            return f"--workers {len(self._local.worker_spec)}: no worker process has been running"
        what = "has not answered" if number is None else "has had no workers"
        return f"--scheduler {self._client.scheduler.address}: {what}"

    def _remedy(self, number: int | None) -> str:
        if self._local is not None:
            return "free memory, or give fewer --workers"
        if number is None:
            return "end it, start another"
        return f"start workers with: dask worker {self._client.scheduler.address}"


async def _replace(local: Any) -> None:
    """Start a worker in place of each that the local cluster has given up; leave those alone that are starting."""
    from distributed.core import Status

    for name in [name for name, nanny in local.workers.items() if nanny.status in (Status.closed, Status.failed)]:
        del local.workers[name]
    local.scale(len(local.worker_spec))
