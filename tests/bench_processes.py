"""Replay, twin, monitor and record as processes that can be killed and started again, and a listener that stays."""

from __future__ import annotations

import subprocess
import threading
import time
from itertools import pairwise
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray

from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.sample_codec import read_state
from ema_twin_msgs.msg import EmaState, Health
from tests.ros_graph import Graph, figures, start_process

READERS = {
    "twin": "ema_twin_sim.nodes.twin",
    "monitor": "ema_twin_sim.nodes.monitor",
    "record": "ema_bench_replay.nodes.record",
}
MODULES = {**READERS, "replay": "ema_bench_replay.nodes.replay"}
HISTORY = 5000
"""Samples that Fast DDS keeps for a reader before a publisher has to wait for it."""
LISTED = 3.0
"""s for which a node that was killed is still taken to be there: see loopback.xml."""

_RECORDING = next(Path(__file__).parent.glob("recordings/*ramp*.CSV"))
_RECORDED_RATE = 500.0
"""Hz."""
_BEGUN = 100_000
"""Bytes of a bag that holds samples."""
_SENT_BEFORE = 0.05
"""s in which what was sent before a node is started arrives here: it tells nothing of that node."""


class BenchProcesses:
    """The four nodes; a recording is played over and over.

    Attributes:
        up: when [s, monotonic] each node's present process told that it runs; before that Python reads libraries.
        arrivals: monotonic times [s] of the bench's samples.
        told: (monotonic time, node, words) of all diagnostics.
        figures: the last figures of each node's diagnostics, by their names.
    """

    def __init__(
        self, rate: float, folder: Path, recording: Path = _RECORDING, recorded_rate: float = _RECORDED_RATE
    ) -> None:
        """Play `rate` samples a second; bags go into `folder`. Waits until all nodes work together."""
        self._speed, self._folder, self._recording = rate / recorded_rate, folder, recording
        self._processes: dict[str, subprocess.Popen[str]] = {}
        self._begun: dict[str, tuple[float, int, int]] = {}
        self._bags = 0
        self._last = b""
        self._health: tuple[float, Health] = (0.0, Health(level=Health.STALE))
        self.up: dict[str, float] = {}
        self.arrivals: list[float] = []
        self.told: list[tuple[float, str, str]] = []
        self.figures: dict[str, dict[str, str]] = {}
        self.graph = Graph()
        node = self.graph.plain_node("listener")
        node.create_subscription(EmaState, "/bench/state", self._on_state, qos.STATE, raw=True)
        node.create_subscription(Health, "/monitor/health", self._on_health, qos.LATEST)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, qos.DIAGNOSTICS)
        try:
            for name in MODULES:
                self.start(name)
            self.wait_for(*MODULES)
        except BaseException:
            self.close()
            raise

    def start(self, name: str) -> None:
        """Start a node's process; what it says goes to nobody."""
        parameters = {"replay": [f"recording:={self._recording}", "loop:=true", f"rate:={self._speed}"]}
        parameters["replay"] += ["subscribers:=4", "patience:=60.0"]
        if name == "record":
            self._bags += 1
            parameters["record"] = [f"output:={self._folder / str(self._bags)}"]
        self.graph.spin_for(_SENT_BEFORE)
        self._begun[name] = (time.monotonic(), *self._newest)
        process = start_process(MODULES[name], *parameters.get(name, []))
        self._processes[name] = process
        self.up.pop(name, None)
        threading.Thread(target=self._listen, args=(name, process), daemon=True).start()

    @property
    def processes(self) -> dict[str, int]:
        """Numbers of the nodes' processes."""
        return {name: process.pid for name, process in self._processes.items()}

    @property
    def health(self) -> Health:
        """The monitor's last."""
        return self._health[1]

    def kill(self, *names: str) -> float:
        """End nodes' processes by SIGKILL; returns when [s, monotonic]."""
        killed = time.monotonic()
        for name in names:
            self._processes[name].kill()
        for name in names:
            self._processes[name].wait()
        return killed

    def wait_for(self, *names: str) -> float:
        """Wait until these nodes work: a sample is compared that the bench sent after their start; a bag holds samples.

        Returns how long that took [s] since the last of them was started.
        """
        self.graph.spin_until(lambda: all(map(self._works, names)), what=" and ".join(names))
        return time.monotonic() - max(self._begun[name][0] for name in names)

    def longest_halt(self, since: float, until: float) -> float:
        """The longest time [s] without a sample of the bench between two times."""
        times = [since, *(arrival for arrival in self.arrivals if since < arrival < until), until]
        return max(after - before for before, after in pairwise(times))

    @property
    def waits(self) -> int:
        """How often the replay has waited some 0.1 s for a reader, which no busy machine makes it do by itself."""
        return int(self.figures.get("replay", {}).get("sent again, a reader was behind", "0"))

    def told_since(self, since: float) -> set[str]:
        """What each node told after that time."""
        return {f"{node}: {words}" for when, node, words in self.told if when > since}

    def close(self) -> None:
        """End all processes."""
        self.kill(*self._processes)
        self.graph.close()

    def _listen(self, name: str, process: subprocess.Popen[str]) -> None:
        """Note when a node tells that it runs, which is the first that it says."""
        if process.stderr.readline() and self._processes.get(name) is process:
            self.up[name] = time.monotonic()
        process.stderr.read()

    def _works(self, name: str) -> bool:
        if name == "record":
            bag = self._folder / str(self._bags) / f"{self._bags}.mcap"
            return bag.exists() and bag.stat().st_size > _BEGUN
        begun, *before = self._begun[name]
        arrived, health = self._health
        new = arrived > begun and self._compared > tuple(before)
        return new and health.compared > 0 and health.level != Health.STALE

    @property
    def _compared(self) -> tuple[int, int]:
        """Run and stamp [ns] of the newest sample that was compared."""
        _, health = self._health
        return health.run, health.header.stamp.sec * 10**9 + health.header.stamp.nanosec

    def _on_state(self, message: bytes) -> None:
        self.arrivals.append(time.monotonic())
        self._last = message

    @property
    def _newest(self) -> tuple[int, int]:
        """Run and stamp [ns] of the newest sample of the bench."""
        state = read_state(self._last) if self._last else None
        return (0, 0) if state is None else (state.run, state.stamp)

    def _on_health(self, health: Health) -> None:
        self._health = time.monotonic(), health

    def _on_diagnostics(self, array: DiagnosticArray) -> None:
        for status in array.status:
            name = status.name.partition(":")[0]
            self.figures[name] = figures(status)
            self.told.append((time.monotonic(), name, status.message))
