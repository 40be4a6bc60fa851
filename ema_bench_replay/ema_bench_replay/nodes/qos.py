"""Quality of service of every topic, in one place: publisher and subscriber connect only if they match."""

from functools import partial

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

_KEPT = DurabilityPolicy.TRANSIENT_LOCAL  # a late reader gets what the publisher holds
_FROM_NOW = DurabilityPolicy.VOLATILE
_all = partial(QoSProfile, reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_ALL)
_last = partial(QoSProfile, reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_LAST)

STATE = _all(durability=_KEPT)
"""Samples: none is lost. A late reader gets earlier samples, up to the 5000 that Fast DDS keeps; a slow reader makes
`publish` raise (see `KeepAllPublisher`)."""

STATE_FROM_NOW = _all(durability=_FROM_NOW)
"""For a subscriber that joins a running bench: samples from now on only."""

RESIDUAL = _last(durability=_FROM_NOW, depth=2000)

LATEST = _last(durability=_KEPT, depth=1)
"""Health and run: a late subscriber gets the latest message at once."""

JOINT_STATES = _last(durability=_FROM_NOW, depth=10)

CLOCK = _last(reliability=ReliabilityPolicy.BEST_EFFORT, durability=_FROM_NOW, depth=1)

DIAGNOSTICS = JOINT_STATES


def state(from_start: bool) -> QoSProfile:
    """A sample subscriber's profile: with earlier samples, or from now on."""
    return STATE if from_start else STATE_FROM_NOW
