"""The samples that a twin node publishes."""

from __future__ import annotations

from rclpy.node import Node

from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.joint_states import JointStates
from ema_bench_replay.nodes.keep_all_publisher import KeepAllPublisher
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState


class TwinOutput:
    """Publishes samples on `twin/state`, and some of them on `twin/joint_states`."""

    def __init__(self, node: Node) -> None:
        self._states = KeepAllPublisher(node, EmaState, "twin/state", qos.STATE)
        self._joints = JointStates(node, "twin/joint_states")

    def send(self, stamp: int, run: int, sequence: int, signals: dict[str, float]) -> None:
        """Publish a sample (SI), stamped in ns since the epoch."""
        self._states.send(write_state(stamp, run, sequence, signals))
        self._joints.publish(stamp, signals)

    @property
    def figures(self) -> dict[str, object]:
        """Counts for the diagnostics."""
        return {"samples sent": self._states.sent, "sent again, a reader was behind": self._states.repeated}
