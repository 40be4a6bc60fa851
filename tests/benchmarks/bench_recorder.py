"""How much a killed recorder loses beside replay, twin and monitor: `python -m tests.benchmarks.bench_recorder`.

Each kill is a SIGKILL at a random moment while messages flow. What it lost is the time up to the kill from the first
message that can not be read of its bag any more, but of the bag of a second recorder, which lives.
"""

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from statistics import median

import numpy as np

from ema_bench_replay.bags.mcap_scan import McapScan
from tests import ros_domain  # noqa: F401 - takes a graph of its own
from tests.ros_graph import start_process

TRACE = Path(__file__).parents[1] / "recordings" / "BancoEMA_sine_0.05_0.25Hz.CSV"
TOPICS = ("/bench/state", "/twin/state", "/monitor/residual")
ALLOWED = 0.25
"""s."""
AT_ONCE = 4
"""Kills beside one graph: publishers wait for readers that are dead, until DDS gives them up."""
RECORD = "ema_bench_replay.nodes.record"


def sent_times(file):
    """When each message of each topic in the file was sent, ns, in order."""
    scan = McapScan(file)
    found = defaultdict(list)
    for message in scan.messages():
        found[scan.channels[message.channel].topic].append(message.publish_time)
    return {topic: np.sort(found[topic]) for topic in TOPICS}


def follows(folder, since):
    """Whether the bag that is being written holds messages that were sent after `since` (ns) of all topics."""
    try:
        times = sent_times(folder / f"{folder.name}.mcap")
    except (OSError, ValueError):
        return False
    return all(len(sent) and sent[-1] > since for sent in times.values())


def wait_for(folder, since):
    """Return once the bag follows, as `follows` has it."""
    deadline = time.monotonic() + 40.0
    while not follows(folder, since):
        if time.monotonic() > deadline:
            raise TimeoutError("not all topics flow")
        time.sleep(0.3)


def kill_one(folder):
    """When it was killed, ns, and the last message of each topic that its bag has."""
    begun = time.time_ns()
    record = start_process(RECORD, f"output:={folder}")
    try:
        wait_for(folder, begun + 3_000_000_000)
        time.sleep(random.uniform(0.3, 1.3))
        killed = time.time_ns()
        record.send_signal(signal.SIGKILL)
    finally:
        record.kill()
        record.communicate()
    return killed, {topic: sent[-1] for topic, sent in sent_times(folder / f"{folder.name}.mcap").items()}


def kill_some(kills, folder):
    """Seconds lost in each of some kills beside one graph, the worst topic's."""
    nodes = [
        start_process("ema_twin_sim.nodes.twin"),
        start_process("ema_twin_sim.nodes.monitor"),
        start_process(RECORD, f"output:={folder / 'witness'}"),
        start_process("ema_bench_replay.nodes.replay", f"recording:={TRACE}", "loop:=true", "subscribers:=3"),
    ]
    found = []
    try:
        wait_for(folder / "witness", 0)
        for k in range(kills):
            found.append(kill_one(folder / f"killed_{k}"))
    except TimeoutError as stalled:
        print(f"{stalled}: a new graph", flush=True)
    finally:
        for node in nodes:
            node.send_signal(signal.SIGINT)
        for node in nodes:
            try:
                node.communicate(timeout=30.0)
            except subprocess.TimeoutExpired:
                node.kill()
                node.communicate()
    sent = sent_times(folder / "witness" / "witness.mcap")
    return [max(lost_of(sent[topic], last, killed) for topic, last in kept.items()) for killed, kept in found]


def lost_of(sent, last, killed):
    """Seconds from the first message that was sent after the `last` one kept to the kill; 0 where none was."""
    behind = sent[(sent > last) & (sent < killed)]
    return (killed - behind[0]) * 1e-9 if len(behind) else 0.0


def main(kills=100):
    random.seed(1)
    lost = []
    while len(lost) < kills:
        with tempfile.TemporaryDirectory() as name:
            lost += kill_some(min(AT_ONCE, kills - len(lost)), Path(name))
        if not lost:
            continue
        over = sum(seconds > ALLOWED for seconds in lost)
        told = f"lost {median(lost):.3f} s (median), {max(lost):.3f} s at most, {over} over {ALLOWED:g} s"
        print(f"{len(lost)} kills: {told}; load {os.getloadavg()[0]:.1f}", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
