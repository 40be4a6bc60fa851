"""``make kill``: nodes beside a bench that plays are killed and started again; how long it halts, what the others tell.

python -m tests.kill_nodes [--rates 500 1000] [--nodes twin monitor record replay] [--kills 3] [--orders 24]
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import cycle, islice, permutations
from pathlib import Path
from statistics import median

from tests import ros_domain  # noqa: F401 - before ROS starts
from tests.bench_processes import HISTORY, LISTED, MODULES, BenchProcesses

_APART = 1.0
"""s between the starts of two nodes."""


def kill_and_restart(bench: BenchProcesses, name: str, away: float, watched: float) -> tuple[float, float, set[str]]:
    """Kill a node and start it again `away` seconds later; look on until `watched` seconds after it was killed.

    Returns the bench's longest halt [s], the time from the node's start until it works [s], and what was told, with N
    for each number.
    """
    killed = bench.kill(name)
    bench.graph.spin_for(away)
    bench.start(name)
    works = bench.wait_for(name)
    bench.graph.spin_for(max(2.0, killed + watched - bench.arrivals[-1]))
    return bench.longest_halt(killed), works, {re.sub(r"\d[\d.]*", "N", words) for words in bench.told_since(killed)}


def undisturbed(bench: BenchProcesses, watched: float) -> float:
    """The bench's longest halt [s] where nothing is killed: what this machine makes of it."""
    since = time.monotonic()
    bench.graph.spin_for(watched)
    return bench.longest_halt(since)


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
    print("   Hz killed    kills  halt of the bench    works again after")
    print("                       median      worst    median      worst")
    for rate in asked.rates:
        watched = HISTORY / rate + LISTED
        with tempfile.TemporaryDirectory() as folder:
            bench = BenchProcesses(rate, Path(folder))
            try:
                _print_row(rate, "nothing", [undisturbed(bench, watched) for _ in range(asked.kills)], ())
                for name in asked.nodes:
                    aways = islice(cycle((watched, 0.0, LISTED / 2.0)), asked.kills)
                    kills = [kill_and_restart(bench, name, away, watched) for away in aways]
                    halts, works, told = zip(*kills, strict=True)
                    _print_row(rate, name, () if name == "replay" else halts, works)
                    for words in sorted(set().union(*told)):
                        print(f"          {words}", flush=True)
                orders = list(permutations(MODULES))
                if chosen := orders[:: max(1, len(orders) // asked.orders)] if asked.orders else []:
                    _print_row(rate, "all", (), [restart_in_order(bench, order) for order in chosen])
            finally:
                bench.close()
    return 0


def _print_row(rate: float, name: str, halts: Sequence[float], works: Sequence[float]) -> None:
    halt, work = (
        f"{median(times):7.2f} s {max(times):8.2f} s" if times else f"{'-':>9} {'-':>10}" for times in (halts, works)
    )
    print(f"{rate:5.0f} {name:8} {max(len(halts), len(works)):6} {halt} {work}", flush=True)


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    os._exit(status)  # Fast DDS need not take leave of processes that were killed
