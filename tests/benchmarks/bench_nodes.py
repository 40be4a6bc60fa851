"""Each node in its own process at 500 Hz: processor time, and how soon the twin answers. Then without pacing."""

import os
import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from ros_graph import start_process

from ema_bench_replay.load import load
from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import EmaState

MODULES = {
    "twin": "ema_twin_sim.nodes.twin",
    "monitor": "ema_twin_sim.nodes.monitor",
    "record": "ema_bench_replay.nodes.record",
    "replay": "ema_bench_replay.nodes.replay",
}
MOST_OF_A_CORE = 0.15
LATEST_ANSWER = 5e-3
MOST_MISSED = 0.05
SETTLING, MEASURED, WINDOWS = 3.0, 4.0, 3
"""s, s, and the number of measurements: other work on the machine only adds to a node's share, so the least counts."""


@pytest.fixture
def trace():
    return next(path for path in (Path(__file__).parent.parent / "recordings").glob("*.CSV") if "ramp" in path.name)


@pytest.fixture
def start():
    processes = []

    def start(*arguments):
        processes.append(start_process(*arguments))
        return processes[-1]

    yield start
    for process in processes:
        process.send_signal(signal.SIGINT)
    for process in processes:
        process.communicate(timeout=10)


class Observer:
    """Notes when each sample was sent, in a process beside the nodes.

    The default executor: it alone tells the time at which a message was sent.
    """

    def __init__(self):
        self.context = Context()
        rclpy.init(args=[], context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node("observer", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.sent = {"bench": {}, "twin": {}}

    def listen(self):
        for side in self.sent:
            self.node.create_subscription(EmaState, f"/{side}/state", self._note(self.sent[side]), qos.STATE)

    def _note(self, sent):
        def note(message, info):
            sent[message.sequence] = info["source_timestamp"]

        return note

    def spin_until(self, condition, timeout=60.0):
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end
            self.executor.spin_once(timeout_sec=0.1)

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture
def observer():
    observer = Observer()
    yield observer
    observer.close()


def processor_time(process):
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def start_nodes(start, observer, trace, folder, *parameters):
    """The four nodes; replay begins when the other three read what it sends."""
    nodes = {name: start(MODULES[name], *given) for name, given in (("twin", ()), ("monitor", ()))}
    nodes["record"] = start(MODULES["record"], f"output:={folder / 'bag'}")
    observer.spin_until(lambda: {"twin", "monitor", "record"} <= set(observer.node.get_node_names()))
    nodes["replay"] = start(MODULES["replay"], f"recording:={trace}", "on_end:=wait", "patience:=30", *parameters)
    return nodes


@pytest.mark.timeout(120)
def test_processor_time_at_500_hz(start, observer, trace, tmp_path, capsys):
    nodes = start_nodes(start, observer, trace, tmp_path, "subscribers:=3")
    observer.spin_until(lambda: observer.node.count_publishers("/bench/state"))
    time.sleep(SETTLING)
    shares = dict.fromkeys(nodes, 1.0)
    for _ in range(WINDOWS):
        before = {name: processor_time(process) for name, process in nodes.items()}
        time.sleep(MEASURED)
        for name, process in nodes.items():
            shares[name] = min(shares[name], (processor_time(process) - before[name]) / MEASURED)
    with capsys.disabled():
        print("\nnode       share of a core at 500 Hz")
        for name, share in shares.items():
            print(f"{name:10} {share:6.1%}")
    assert max(shares.values()) <= MOST_OF_A_CORE


@pytest.mark.timeout(120)
def test_the_twin_answers_in_time(start, observer, trace, tmp_path, capsys):
    observer.listen()
    start_nodes(start, observer, trace, tmp_path, "subscribers:=4")
    samples = len(load(trace))
    observer.spin_until(lambda: min(map(len, observer.sent.values())) == samples)
    answered = [observer.sent["twin"][number] - sent for number, sent in observer.sent["bench"].items()]
    latency = np.array(answered) * 1e-9
    median, late, latest = np.percentile(latency, [50, 99, 100])
    with capsys.disabled():
        figures = f"median {median * 1e3:.2f} ms, p99 {late * 1e3:.2f} ms, longest {latest * 1e3:.2f} ms"
        print(f"\nbench sample to the twin's answer: {figures}")
    assert late <= LATEST_ANSWER


@pytest.mark.timeout(120)
def test_unpaced_nothing_is_lost(start, observer, trace, tmp_path, capsys):
    observer.listen()
    start_nodes(start, observer, trace, tmp_path, "subscribers:=4", "rate:=0")
    samples = len(load(trace))
    observer.spin_until(lambda: min(map(len, observer.sent.values())) == samples)
    sent = [*observer.sent["bench"].values(), *observer.sent["twin"].values()]
    elapsed = (max(sent) - min(sent)) * 1e-9
    with capsys.disabled():
        print(f"\nunpaced, four nodes and an observer: {samples / elapsed:.0f} samples/s, none lost")


@pytest.mark.timeout(120)
@pytest.mark.parametrize("rate", [500, 1000])
def test_a_standalone_twin_misses_few_periods(start, observer, rate, capsys):
    observer.listen()
    start(MODULES["twin"], "input:=standalone", "command:=sine:0.02:1", f"rate:={rate}.0")
    sent = observer.sent["twin"]
    observer.spin_until(lambda: len(sent) >= MEASURED * rate)
    elapsed = (max(sent.values()) - min(sent.values())) * 1e-9
    missed = 1.0 - (len(sent) - 1) / (elapsed * rate)
    with capsys.disabled():
        print(f"\na standalone twin at {rate} Hz: {missed:.2%} of the periods missed")
    assert missed <= MOST_MISSED
