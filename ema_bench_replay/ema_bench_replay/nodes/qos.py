"""Quality of service of every topic, in one place: publisher and subscriber connect only if they match."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

STATE = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    history=HistoryPolicy.KEEP_ALL,
)
"""Samples: none is lost. A late reader gets earlier samples, up to the 5000 that Fast DDS keeps; a slow reader makes
`publish` raise (see `KeepAllPublisher`)."""

STATE_FROM_NOW = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_ALL,
)
"""For a subscriber that joins a running bench: samples from now on only."""

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
"""Health and run: a late subscriber gets the latest message at once."""

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
    """A sample subscriber's profile: with earlier samples, or from now on."""
    return STATE if from_start else STATE_FROM_NOW
