"""A machine's shafts as `sensor_msgs/JointState`, at most 100 times a second."""

from __future__ import annotations

import time
from collections.abc import Mapping

from rclpy.node import Node
from sensor_msgs.msg import JointState

from . import qos
from .messages import joint_message

_PERIOD = 10_000_000
"""ns; tools only draw joint states, and 100 Hz is more than they show."""


class JointStates:
    """Publishes at most one sample per period, and drops the others."""

    def __init__(self, node: Node, topic: str) -> None:
        self._publisher = node.create_publisher(JointState, topic, qos.JOINT_STATES)
        self._due = 0

    def publish(self, stamp: int, signals: Mapping[str, float]) -> None:
        """Publish a sample (SI), stamped in ns since the epoch, unless the last is too recent."""
        now = time.monotonic_ns()
        if now < self._due:
            return
        self._due = max(self._due + _PERIOD, now)
        self._publisher.publish(joint_message(stamp, signals))
