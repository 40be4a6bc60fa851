"""One case given to discovery, in a worker process; and many of them, two at a time, with progress."""

from __future__ import annotations

import math
import multiprocessing
import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.model import Model, load_model
from ema_twin_sim.simulation.simulate import simulate

from .cases import Case
from .folders import saved_and_read
from .judge import Verdict, broken, judge

WORKERS = 2
_CURRENT_FLOOR = 0.003  # A, the noise of the bench's current sensor


def solve(case: Case, without: Sequence[str] = ()) -> Verdict:
    """What discovery makes of a case, judged; ``without`` are effects that it may not name."""
    train = case.train
    if case.unkind.counter_jump:
        with tempfile.TemporaryDirectory() as folder:
            train = saved_and_read(case, Path(folder))
    model = load_model("polito_bench")
    for id in case.remove_from_stock_model:
        model = model.without_effect(id)
    start = time.perf_counter()
    try:
        found = discover(train, model, without=tuple(without))
        seconds = time.perf_counter() - start
        return judge(case, found.as_json(), seconds, _removed(case, model, found.model))
    except Exception as error:  # whatever it is, the case is lost and the others go on
        return broken(case, error, time.perf_counter() - start)


class Solvers:
    """Worker processes that solve cases, several at a time."""

    def __init__(self, workers: int = WORKERS) -> None:
        # libraries that each take all cores would only get in each other's way
        for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"):
            os.environ.setdefault(name, "1")
        self._pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))

    def __enter__(self) -> Solvers:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def __call__(self, cases: Sequence[Case], without: Sequence[str] = ()) -> Iterator[Verdict]:
        """The cases' verdicts as they come; ``without`` are effects, one a case, that it may not name."""
        kept: list[tuple[str, ...]] = [(id,) for id in without] or [()] * len(cases)
        waiting = [self._pool.submit(solve, case, ids) for case, ids in zip(cases, kept, strict=True)]
        for future in as_completed(waiting):
            yield future.result()


def _removed(case: Case, before: Model, after: Model) -> float:
    """Share of the current's excess error (above its noise) that is gone on recordings discovery never saw."""
    if not case.hidden or any("speed_setpoint" not in recording.signals for recording in case.holdout):
        return math.nan

    def error(model: Model) -> float:
        left = [r.signals["current"] - simulate(model, r, "setpoint").signals["current"] for r in case.holdout]
        return float(np.mean(np.concatenate(left) ** 2))

    excess = error(before) - _CURRENT_FLOOR**2
    return (error(before) - error(after)) / excess if excess > (0.3 * _CURRENT_FLOOR) ** 2 else math.nan
