"""A publisher that loses no message: it waits for its slowest reader."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile

from .spin import interrupted


class KeepAllPublisher:
    """Publishes serialised messages on a keep-all topic.

    Once a reader is a full history behind, `publish` blocks for about 0.1 s and raises. Sending the same message again
    is the flow control: the sender is no faster than its slowest reader. Readers in the sender's own executor cannot
    fall that far behind, as long as each callback sends far fewer messages than a history holds.

    Attributes:
        sent: messages sent.
        repeated: times that a message had to be sent again.
    """

    def __init__(self, node: Node, message_type: type, topic: str, qos: QoSProfile) -> None:
        self._context = node.context
        self._publisher = node.create_publisher(message_type, topic, qos)
        self.sent = 0
        self.repeated = 0

    def try_send(self, message: bytes) -> bool:
        """Send; false if a reader is behind, and the same message must be sent again later."""
        try:
            self._publisher.publish(message)
        except rclpy_implementation.RCLError:
            self.repeated += 1
            return False
        self.sent += 1
        return True

    def send(self, message: bytes) -> None:
        """Send, and wait for readers that are behind. Gives up only when the process is to end."""
        while not self.try_send(message):
            if interrupted() or not self._context.ok():
                return

    @property
    def readers(self) -> int:
        """Number of subscriptions found."""
        return self._publisher.get_subscription_count()

    @property
    def all_received(self) -> bool:
        """Whether every reader has received everything sent."""
        return self._publisher.wait_for_all_acked(Duration())
