"""``make soak``: the four nodes run at rate 1 for a long time: what their memory, their samples and their time do.

A process grows until its buffers are full: the monitor's history, and the queues of samples that the middleware makes
where a reader stood still, and keeps. So each reader is halted for a while at first; from then on nothing may grow.

python -m tests.soak [--minutes 60] [--rate 1000]
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import tempfile
import time
from collections import deque
from pathlib import Path
from statistics import median

import numpy as np

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.sample_codec import read_state
from ema_twin_msgs.msg import EmaState
from ema_twin_sim.model.model_file import load_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests import ros_domain  # noqa: F401 - before ROS starts
from tests.bench_processes import LISTED, MODULES, READERS, BenchProcesses
from tests.sockets import family

HISTORY = 150_000
"""Samples that the monitor keeps for a diagnosis: the largest of all buffers."""
_STOOD_STILL = 0.8 * LISTED
"""s for which a reader is halted: the others take one that is silent for longer to be gone, and keep nothing for it."""
_CATCHING_UP = 10.0
"""s after that."""
_SETTLED = 10.0
"""s after which what came before is over."""
_LOOK = 1.0
"""s between two looks at the memory."""


def long_run(folder: Path, rate: float, seconds: float) -> Path:
    """A recording of the stock model at so many samples a second, as an MCAP."""
    model = load_model("polito_bench").with_value("sensors.sample_period", 1.0 / rate)
    path = folder / "long.mcap"
    write_mcap(virtual_bench(model, parse_command("sine:0.02:0.5"), seconds, name="long"), path)
    return path


class Soak:
    """Watches the nodes.

    Attributes:
        begun: when [s, monotonic] it began to.
        missing: samples that the monitor missed before.
        memory: (time [s] since then, bytes by process) of each look; only what the process made, no files.
        full: time [s] from which on all buffers are; None before.
        load: how many processes ran or waited for a processor of this machine, at each look.
        late: by how much [s] the twin's samples came later than the first did, by their stamps; one a second.
    """

    def __init__(self, bench: BenchProcesses) -> None:
        self._bench = bench
        self._start: tuple[float, int] | None = None
        self._last = 0.0
        self.begun = 0.0
        self.missing = 0
        self.memory: list[tuple[float, dict[str, int]]] = []
        self.load: list[float] = []
        self.full: float | None = None
        self.late: list[tuple[float, float]] = []
        self._recent: deque[float] = deque(maxlen=2000)
        bench.graph.nodes[0].create_subscription(EmaState, "/twin/state", self._on_twin, qos.STATE, raw=True)

    def fill_queues(self) -> None:
        """Let each reader stand still once, and catch up: no halt of a busy machine then makes a longer queue."""
        for name in READERS:
            os.kill(self._bench.processes[name], signal.SIGSTOP)
            self._bench.graph.spin_for(_STOOD_STILL)
            os.kill(self._bench.processes[name], signal.SIGCONT)
            self._bench.graph.spin_for(_CATCHING_UP)

    def watch(self, seconds: float) -> None:
        """Look on for so long."""
        self.begun = time.monotonic()
        self._start, self._last = None, 0.0
        self.missing = self._bench.health.missing
        self.late.clear()
        self._recent.clear()
        while (passed := time.monotonic() - self.begun) < seconds:
            self.memory.append((passed, _memory(self._bench.processes)))
            self.load.append(os.getloadavg()[0])
            if self.full is None and self._bench.health.compared > HISTORY:
                self.full = passed + _SETTLED
            self._bench.graph.spin_for(_LOOK)

    def _on_twin(self, message: bytes) -> None:
        now, stamp = time.monotonic(), read_state(message).stamp
        if self._start is None:
            self._start = now, stamp
        passed = now - self._start[0]
        self._recent.append(passed - (stamp - self._start[1]) * 1e-9)
        if now - self._last > 1.0:
            self._last = now
            self.late.append((passed, min(self._recent)))  # what is left is the clocks', not the scheduler's
            self._recent.clear()


def _memory(processes: dict[str, int]) -> dict[str, int]:
    """Bytes of each process and of those that it has started."""
    found = {}
    for name, number in processes.items():
        for child, process in enumerate(family(number)):
            try:
                lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
            except OSError:
                continue
            kilobytes = next((line.split()[1] for line in lines if line.startswith("RssAnon")), "0")
            found[name if not child else f"{name}: its {child}. child"] = int(kilobytes) << 10
    return found


def sizes_in_time(memory: list[tuple[float, dict[str, int]]], name: str, full: float) -> list[float]:
    """Sizes [MiB] of a process: medians of five equal stretches of the time after `full` s; none where it is short."""
    sizes = [held[name] / 2**20 for passed, held in memory if passed > full and name in held]
    return [float(median(part)) for part in np.array_split(sizes, 5)] if len(sizes) >= 10 else []


def main() -> int:
    """Run and print what was found; status 1 where samples were lost or a process grew by more than 1 MiB."""
    parser = argparse.ArgumentParser(prog="make soak", description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=5.0, help="how long; 60 is what is promised")
    parser.add_argument("--rate", type=float, default=1000.0, help="samples a second")
    asked = parser.parse_args()
    seconds = asked.minutes * 60.0
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        recording = long_run(folder, asked.rate, seconds + 300.0)  # one run: the start takes its time
        bench = BenchProcesses(asked.rate, folder, recording, asked.rate)
        try:
            soak = Soak(bench)
            soak.fill_queues()
            soak.watch(seconds)
            bench.graph.spin_for(2.0)
            wrong = report(bench, soak)
        finally:
            bench.close()
    return wrong


def report(bench: BenchProcesses, soak: Soak) -> int:
    """Print what was found; returns 1 where a promise was broken, or nothing was looked at."""
    wrong = 0
    full = np.inf if soak.full is None else soak.full
    ran = f"load of the machine {median(soak.load):.1f}, at most {max(soak.load):.1f}" if soak.load else ""
    print(f"memory, from {full:.0f} s on, when all buffers are full; {ran}")
    for name in sorted({name for _, held in soak.memory for name in held}):
        if not (sizes := sizes_in_time(soak.memory, name, full)):
            wrong = 1
            print(f"  {name:24} not looked at: the run must be longer")
            continue
        wrong |= sizes[-1] - sizes[0] > 1.0
        course = " ".join(f"{size:7.2f}" for size in sizes)
        print(f"  {name:24} {course} MiB, grew by {sizes[-1] - sizes[0]:+.2f} MiB")
    health, missing = bench.health, bench.health.missing - soak.missing
    print(f"samples: {health.compared} compared, {missing} missing; run {health.run}")
    wrong |= missing > 0 or health.compared == 0
    for node in ("twin", "monitor", "record", "replay"):
        for key, value in bench.figures.get(node, {}).items():
            if any(
                word in key for word in ("lost", "late", "twice", "behind", "went back", "wrong stamp", "not written")
            ):
                print(f"  {node}: {key}: {value}")
                wrong |= node != "record" and "lost" in key and value not in ("0", "none")
    recorder = max((told for told in bench.told if told[1] == "record"), default=(0.0, "", ""))[2]
    wrong |= any(topic in recorder for topic in ("/bench/state", "/twin/state"))  # of others only the newest are kept
    passed, late = np.array([(t, by) for t, by in soak.late if t > _SETTLED]).reshape(-1, 2).T
    if len(late) > 20:
        late -= late.min()
        fifths = [part.min() for part in np.array_split(late, 5)]
        course = " ".join(f"{1e3 * by:.2f}" for by in fifths)
        print(f"time: the twin's earliest sample in each fifth of {passed[-1] / 60:.1f} min came {course} ms late,")
        print(f"  by the stamps; the earliest of a second {late.max():.2f} s late at most")
    for node in MODULES:
        last = max((told for told in bench.told if told[1] == node), default=(0.0, node, "nothing"))
        print(f"  {node} tells: {last[2]}")
    print(f"bench: longest halt {bench.longest_halt(soak.begun, bench.arrivals[-1]):.2f} s")
    return int(wrong)


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    os._exit(status)  # Fast DDS need not take leave of processes that were killed
