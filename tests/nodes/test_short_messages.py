"""Messages shorter than any in CDR, from another process: what the middleware makes of them, and what is told then."""

import subprocess
import sys

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import EmaState
from ema_twin_sim.nodes.monitor import MonitorNode
from ema_twin_sim.nodes.twin import TwinNode

BENCH = """
import sys, time
import rclpy
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState

rclpy.init()
publisher = rclpy.create_node("bench").create_publisher(EmaState, "/bench/state", qos.STATE)
signals = dict.fromkeys(("speed_setpoint", "speed", "current", "motor_position", "output_position"), 0.0)
while publisher.get_subscription_count() < 2:
    time.sleep(0.05)
for sequence in range(400):
    if sequence == 10:
        for short in (b"1", b"12", b"123"):
            publisher.publish(short)
    if sequence == 40:
        sys.stdin.readline()
        publisher.publish(b"")
    publisher.publish(write_state(10**9 + sequence * 2_000_000, 1, sequence, signals))
    if sequence > 40:
        time.sleep(0.01)
sys.stdin.read()
"""


@pytest.mark.slow
def test_short_messages_are_counted_and_one_without_bytes_is_told_as_silence(graph):
    """One, two and three bytes are filled up to four. What follows a message of none is sent, and never comes."""
    twin = graph.add(TwinNode)
    monitor = graph.add(MonitorNode)
    tester = graph.plain_node()
    answers, said = [], graph.diagnostics(tester)
    tester.create_subscription(EmaState, "/twin/state", answers.append, qos.STATE)
    bench = subprocess.Popen([sys.executable, "-c", BENCH], stdin=subprocess.PIPE)
    try:
        graph.spin_until(lambda: len(answers) == 40 and monitor.pairing.compared == 40)
        assert twin.failure is None
        told = "3 messages on bench/state are no EmaState and were left out"
        graph.spin_until(lambda: {"twin", "monitor"} <= said.keys() and all(told in said[n].message for n in said))
        bench.stdin.write(b"\n")
        bench.stdin.flush()
        graph.spin_until(lambda: said["monitor"].level == DiagnosticStatus.STALE)
        assert "no samples received" in said["monitor"].message
        assert bench.poll() is None  # it still sends
        assert len(answers) == 40
    finally:
        bench.kill()
        bench.wait()
