"""Quality of service of every topic, in one place: a publisher and a subscriber that differ here do not meet."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

STATE = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    history=HistoryPolicy.KEEP_ALL,
)
"""Samples: none is lost. A reader that is late gets what was sent before it came, up to the 5000 that Fast DDS keeps; a
reader that is slow makes `publish` raise (see `KeepAllPublisher`)."""

STATE_FROM_NOW = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_ALL,
)
"""For a subscriber that joins a bench which has been running: samples from now on only."""

RESIDUAL = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=2000,
)

LATEST = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
)
"""Health and run: who comes late learns the present state at once."""

JOINT_STATES = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=10,
)

CLOCK = QoSProfile(
    reliability=ReliabilityPolicy.BEST_EFFORT,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
)

DIAGNOSTICS = JOINT_STATES


def state(from_start: bool) -> QoSProfile:
    """A sample subscriber's profile: with the samples sent before it came, or from now on."""
    return STATE if from_start else STATE_FROM_NOW
