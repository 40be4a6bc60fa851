"""Times of several calls side by side in one run: ratios, since machines differ and are noisy; and of processes."""

import math
import subprocess
import time
from collections.abc import Callable

import psutil


def fastest(rounds: int, *calls: Callable[[], object]) -> list[float]:
    """The least process time [s] of each call, in turn, so that a machine's moods hit all alike."""
    best = [math.inf] * len(calls)
    for _ in range(rounds):
        for k, call in enumerate(calls):
            begin = time.process_time()
            call()
            best[k] = min(best[k], time.process_time() - begin)
    return best


def processor_time(process: subprocess.Popen) -> float:
    """Seconds of a processor that a process has had."""
    of = psutil.Process(process.pid).cpu_times()
    return of.user + of.system
