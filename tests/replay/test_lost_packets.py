"""What the transport drops, or a reader refuses, is sent again at once, but not over and over."""

import signal
import subprocess
import sys

import pytest
import rclpy

from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.keep_all_publisher import KeepAllPublisher
from ema_bench_replay.nodes.sample_codec import read_state, write_state
from ema_twin_msgs.msg import EmaState
from tests.bench_processes import HISTORY
from tests.namespaces import ALONE, needs_own_network

READER = """
import sys, time
import rclpy
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.sample_codec import read_state
from ema_bench_replay.nodes.spin import make_executor
from ema_twin_msgs.msg import EmaState
rclpy.init()
node = rclpy.create_node("reader")
def tell(message):
    print(read_state(message).sequence, flush=True)
def work(message):
    time.sleep(0.0005)
node.create_subscription(EmaState, "/stream", {"tell": tell, "work": work}[sys.argv[1]], qos.STATE, raw=True)
executor = make_executor([node])
while True:
    executor.spin_once(timeout_sec=0.2)
"""
"""Tells the numbers of the samples, or is slow with each."""
BESIDE_IT = """
import subprocess, sys, time
from pathlib import Path
from ema_bench_replay.nodes import loopback
loopback.keep_to_this_machine()
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.keep_all_publisher import KeepAllPublisher
from ema_twin_msgs.msg import EmaState
from tests.replay.test_lost_packets import HISTORY, READER, send
from tests.ros_graph import Graph
def sent_bytes():
    (line,) = (line for line in Path("/proc/net/dev").read_text().splitlines() if line.strip().startswith("lo:"))
    return int(line.partition(":")[2].split()[0])
graph = Graph()
publisher = KeepAllPublisher(graph.plain_node("writer"), EmaState, "/stream", qos.STATE)
reader = subprocess.Popen([sys.executable, "-c", READER, "work"])
try:
    graph.spin_until(lambda: publisher.readers == 1)
    send(publisher, HISTORY)
    send(publisher, 2 * HISTORY)  # all places are full by then
    before, begun = sent_bytes(), time.monotonic()
    send(publisher, HISTORY)
    print((sent_bytes() - before) / (time.monotonic() - begun))
finally:
    reader.kill()
    reader.wait()
    graph.close()
"""
UNTAKEN = 500
"""Samples that a reader holds for its node: see loopback.xml."""
TOLD = 0.02
"""s between two times that a sender tells what it has sent: see loopback.xml."""
ASKED_AT_ONCE = 256
"""Samples that a reader may ask for at a time (DDS-RTPS 2.5, 9.4.2.6)."""
WITH_HEADERS = 1.8
"""Times the size of a sample, that it has on the way: 1.35 to 1.44, beside two busy processes as well; 2.2 to 2.8 where
a sender tells with every sample."""
FEW = 8
"""Tries of 0.1 s each that a sample may need; where Fast DDS asks once in 3 s, its default, it is 13 to 30."""


@pytest.mark.slow
def test_what_was_dropped_comes_without_a_halt(graph):
    """A burst of nearly all samples that are kept is more than the kernel's buffer of a process that stands still."""
    publisher = KeepAllPublisher(graph.plain_node("writer"), EmaState, "/stream", qos.STATE)
    reader = subprocess.Popen([sys.executable, "-c", READER, "tell"], stdout=subprocess.PIPE, text=True)
    try:
        graph.spin_until(lambda: publisher.readers == 1)
        for _ in range(4):  # how far the kernel's buffer is from full is chance
            send(publisher, 100)
            wait_for_last(reader, publisher)
            graph.spin_until(lambda: publisher.all_received)
            reader.send_signal(signal.SIGSTOP)
            send(publisher, HISTORY - 100)
            graph.spin_for(0.5)  # nothing of it is still under way
            repeated = publisher.repeated
            reader.send_signal(signal.SIGCONT)
            send(publisher, 1000)
            wait_for_last(reader, publisher)
            assert publisher.repeated - repeated <= FEW
    finally:
        reader.kill()
        reader.communicate()


def send(publisher, count):
    for number in range(publisher.sent, publisher.sent + count):
        publisher.send(write_state(number * 1_000_000, 1, number, {}))


def wait_for_last(reader, publisher):
    while int(reader.stdout.readline()) < publisher.sent - 1:
        pass


def test_a_reader_that_stands_still_holds_few_samples(graph):
    """A full store is searched for every sample that is asked for again: a large one keeps a late reader late."""
    publisher = KeepAllPublisher(graph.plain_node("writer"), EmaState, "/stream", qos.STATE)
    reader = rclpy.create_node("reader", context=graph.context)  # nobody serves it
    reader.create_subscription(EmaState, "/stream", lambda message: None, qos.STATE, raw=True)
    graph.spin_until(lambda: publisher.readers == 1)
    while publisher.try_send(write_state(publisher.sent * 1_000_000, 1, publisher.sent, {})):
        assert publisher.sent <= HISTORY + UNTAKEN
    assert publisher.sent > HISTORY
    reader.destroy_node()


def test_what_a_full_reader_refused_comes_once_it_is_served(graph):
    """Within a process as well, where the sender has nothing more to send."""
    publisher = KeepAllPublisher(graph.plain_node("writer"), EmaState, "/stream", qos.STATE)
    heard = []
    reader = graph.plain_node("reader")
    reader.create_subscription(EmaState, "/stream", lambda m: heard.append(read_state(m).sequence), qos.STATE, raw=True)
    graph.spin_until(lambda: publisher.readers == 1)
    send(publisher, 5 * UNTAKEN)
    graph.spin_until(lambda: len(heard) == 5 * UNTAKEN)
    assert heard == [*range(5 * UNTAKEN)]


@pytest.mark.slow
@needs_own_network
def test_what_a_slow_reader_has_no_place_for_is_not_sent_over_and_over():
    """Once all places at the sender and at the reader are full, the reader refuses what comes next, and asks for it.

    A sender that tells with every sample what it has sent is asked as often, for 256 samples each time.
    """
    done = subprocess.run([*ALONE, sys.executable, "-c", BESIDE_IT], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    at_most = ASKED_AT_ONCE * len(write_state(0, 1, 0, {})) / TOLD
    assert float(done.stdout) < WITH_HEADERS * at_most
