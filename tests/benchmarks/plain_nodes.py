"""Nodes as the tutorials of ROS write them, to measure ours beside: what rclpy and this machine themselves take.

python -m tests.benchmarks.plain_nodes --ros-args -p rate:=0.0      # sends every /bench/state on as /plain/state
python -m tests.benchmarks.plain_nodes --ros-args -p rate:=500.0    # sends by a timer of its own
"""

import contextlib

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node

from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import EmaState


class PlainNode(Node):
    """Answers each bench sample, or sends as often as its ``rate`` says."""

    def __init__(self):
        super().__init__("plain")
        rate = self.declare_parameter("rate", 0.0).value
        self._sent = 0
        self._publisher = self.create_publisher(EmaState, "plain/state", qos.STATE)
        if rate:
            self.create_timer(1.0 / rate, self._send)
        else:
            self.create_subscription(EmaState, "bench/state", self._publisher.publish, qos.STATE)

    def _send(self):
        self._publisher.publish(EmaState(sequence=self._sent))
        self._sent += 1


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.init()
        rclpy.spin(PlainNode())
