"""``make kill``: nodes beside a bench that plays are killed and started again; how long it halts, what the others tell.

python -m tests.kill_nodes [--rates 500 1000] [--nodes twin monitor record replay] [--kills 3] [--orders 24]
"""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import cycle, islice, permutations
from pathlib import Path
from statistics import median
from typing import NamedTuple

from tests import ros_domain  # noqa: F401 - before ROS starts
from tests.bench_processes import HISTORY, LISTED, MODULES, BenchProcesses

_APART = 1.0
"""s between the starts of two nodes."""
_LONGEST_HALT, _LONGEST_PAIRING = 0.3, 3.0
"""s that are promised. Where others keep the processors busy, the row of nothing killed tells what they alone do."""
_PRESSURE = Path("/proc/pressure/cpu")
"""Where Linux counts the time [µs] in which something waited for a processor."""


class Kill(NamedTuple):
    """What followed on a kill: times in s."""

    dead: float  # longest halt of the bench while the node was dead, and once it worked again
    joins: float  # longest halt of the bench from the node's start until it worked
    works: float  # from the node's start until it worked
    pairs: float  # from when its process was up until it worked
    waits: int  # how often the bench waited some 0.1 s for a reader, from the kill on
    told: set[str]  # by all nodes, with N for each number


def kill_and_restart(bench: BenchProcesses, name: str, away: float, watched: float) -> Kill:
    """Kill a node and start it again `away` seconds later; look on until `watched` seconds after it was killed."""
    waits = bench.waits if name != "replay" else 0
    killed = bench.kill(name)
    bench.graph.spin_for(away)
    begun = time.monotonic()
    bench.start(name)
    works = bench.wait_for(name)
    joined = time.monotonic()
    bench.graph.spin_for(max(2.0, killed + watched - joined))
    dead = max(bench.longest_halt(killed, begun), bench.longest_halt(joined, time.monotonic()))
    told = {re.sub(r"\d[\d.]*", "N", words) for words in bench.told_since(killed)}
    pairs = joined - bench.up.get(name, joined)
    return Kill(dead, bench.longest_halt(begun, joined), works, pairs, bench.waits - waits, told)


def undisturbed(bench: BenchProcesses, watched: float) -> float:
    """The bench's longest halt [s] where nothing is killed: what this machine makes of it."""
    since = time.monotonic()
    bench.graph.spin_for(watched)
    return bench.longest_halt(since, time.monotonic())


def restart_in_order(bench: BenchProcesses, order: Sequence[str]) -> float:
    """Kill all nodes at once and start them in this order: the time from the last one's start until all work [s]."""
    bench.kill(*order)
    for name in order:
        bench.graph.spin_for(_APART)
        bench.start(name)
    return bench.wait_for(*order)


def main() -> int:
    """Run what was asked for and print a table."""
    parser = argparse.ArgumentParser(prog="make kill", description=__doc__.partition("\n")[0])
    parser.add_argument("--rates", type=float, nargs="+", default=[500.0, 1000.0], help="samples a second")
    parser.add_argument("--nodes", nargs="*", default=list(MODULES), choices=list(MODULES), help="nodes to kill")
    parser.add_argument("--kills", type=int, default=3, help="kills of each node at each rate")
    parser.add_argument("--orders", type=int, default=4, help="orders in which all four are started again; 24 is all")
    asked = parser.parse_args()
    print("                     the bench halts [s]: median, worst, how many within 0.3 s    works again after [s]")
    print("   Hz killed  times    it is dead            it joins            within 3 s        CPU wanted")
    for rate in asked.rates:
        watched = HISTORY / rate + LISTED
        with tempfile.TemporaryDirectory() as folder:
            bench = BenchProcesses(rate, Path(folder))
            try:
                since = waited()
                _print_row(rate, "nothing", since, [undisturbed(bench, watched) for _ in range(asked.kills)])
                for name in asked.nodes:
                    aways = islice(cycle((watched, 0.0, LISTED / 2.0)), asked.kills)
                    since = waited()
                    kills = [kill_and_restart(bench, name, away, watched) for away in aways]
                    dead, joins, works = ([kill[column] for kill in kills] for column in range(3))
                    if name == "replay":  # without it there is no stream
                        dead, joins = [], []
                    _print_row(rate, name, since, dead, joins, works)
                    print(f"          the bench waited for a reader {sum(kill.waits for kill in kills)} times")
                    pairs = [kill.pairs for kill in kills]
                    print(f"          works {median(pairs):.2f} s after its process is up, at most {max(pairs):.2f} s")
                    for words in sorted(set().union(*(kill.told for kill in kills))):
                        print(f"          {words}", flush=True)
                orders = list(permutations(MODULES))
                if chosen := orders[:: max(1, len(orders) // asked.orders)] if asked.orders else []:
                    since = waited()
                    _print_row(rate, "all", since, [], [], [restart_in_order(bench, order) for order in chosen])
            finally:
                bench.close()
    return 0


def waited() -> tuple[float, float]:
    """The present time, and that for which something waited for a processor until now [s]; NaN where none counts it."""
    total = re.search(r"total=(\d+)", _PRESSURE.read_text()) if _PRESSURE.exists() else None
    return time.monotonic(), float(total[1]) * 1e-6 if total else math.nan


def _print_row(rate: float, name: str, since: tuple[float, float], *columns: Sequence[float]) -> None:
    """Median and worst of each column's times [s], how many are as promised, and how wanted the processors were."""
    cells = []
    for times, most in zip(columns, (_LONGEST_HALT, _LONGEST_HALT, _LONGEST_PAIRING), strict=False):
        kept = sum(seconds <= most for seconds in times)
        cells.append(f"{median(times):6.2f} {max(times):6.2f} {kept:3}" if times else f"{'-':>6} {'-':>6} {'-':>3}")
    cells += [" " * 17] * (3 - len(cells))
    passed, lacked = (now - then for now, then in zip(waited(), since, strict=True))
    print(f"{rate:5.0f} {name:8} {max(map(len, columns)):5}  {'   '.join(cells)}    {lacked / passed:4.0%}", flush=True)


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    os._exit(status)  # Fast DDS need not take leave of processes that were killed
