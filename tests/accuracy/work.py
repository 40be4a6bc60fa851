"""One case given to discovery, in a worker process; and many of them, two at a time, with progress."""

from __future__ import annotations

import math
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import TypeVar

import numpy as np

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.model import Model
from ema_twin_sim.simulation.simulate import simulate

from .cases import Case
from .folders import readable_train
from .judge import Verdict, broken, judge

Answer = TypeVar("Answer")
WORKERS = 2
_CURRENT_FLOOR = 0.003  # A, the noise of the bench's current sensor


def solve(case: Case, without: Sequence[str] = ()) -> Verdict:
    """What discovery makes of a case, judged; ``without`` are effects that it may not name."""
    model = case.start_model
    start = time.perf_counter()
    try:
        found = discover(readable_train(case), model, without=tuple(without))
        seconds = time.perf_counter() - start
        return judge(case, found.as_json(), seconds, _removed(case, model, found.model))
    except Exception as error:  # whatever it is, the case is lost and the others go on
        return broken(case, error, time.perf_counter() - start)


def _end_with_parent() -> None:
    """Let a worker end when the process that started it does, even if that was killed."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def follow() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


class Solvers:
    """Worker processes that solve cases, several at a time."""

    def __init__(self, workers: int = WORKERS) -> None:
        # libraries that each take all cores would only get in each other's way
        for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"):
            os.environ.setdefault(name, "1")
        context = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_end_with_parent)

    def __enter__(self) -> Solvers:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def __call__(self, cases: Sequence[Case], without: Sequence[str] = ()) -> Iterator[Verdict]:
        """The cases' verdicts as they come; ``without`` are effects, one a case, that it may not name."""
        return self.each(solve, cases, [(id,) for id in without])

    def each(
        self,
        what: Callable[[Case, Sequence[str]], Answer],
        cases: Sequence[Case],
        without: Sequence[Sequence[str]] = (),
    ) -> Iterator[Answer]:
        """What a function makes of each case, beside the effects that it may not name, as they come."""
        barred = without or [()] * len(cases)
        waiting = [self._pool.submit(what, case, ids) for case, ids in zip(cases, barred, strict=True)]
        for future in as_completed(waiting):
            yield future.result()


def _removed(case: Case, before: Model, after: Model) -> float:
    """Share of the current's excess error (above its noise) that is gone on recordings discovery never saw."""
    if not case.hidden or any("speed_setpoint" not in recording.signals for recording in case.holdout):
        return math.nan

    def error(model: Model) -> float:
        left = [r.signals["current"] - simulate(model, r, "setpoint").signals["current"] for r in case.holdout]
        return float(np.mean(np.concatenate(left) ** 2))

    floor = _CURRENT_FLOOR / case.told_in.factor("A")
    excess = error(before) - floor**2
    return (error(before) - error(after)) / excess if excess > (0.3 * floor) ** 2 else math.nan
