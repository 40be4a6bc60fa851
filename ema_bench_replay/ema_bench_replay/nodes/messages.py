"""Messages from plain Python: nanoseconds, and mappings of signal names to float. (Samples: see `sample_codec`.)"""

from __future__ import annotations

import math
from collections.abc import Mapping

from builtin_interfaces.msg import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from ema_twin_msgs.msg import Signals

from .sample_codec import COMPARED

_UNKNOWN = dict.fromkeys(COMPARED, math.nan)


def header(stamp: int) -> Header:
    """A header with the stamp given in nanoseconds since the epoch."""
    seconds, nanoseconds = divmod(stamp, 1_000_000_000)
    return Header(stamp=Time(sec=seconds, nanosec=nanoseconds))


def signals_message(signals: Mapping[str, float]) -> Signals:
    """The compared signals (SI) as a message; those not given are NaN."""
    return Signals(**(_UNKNOWN | {name: signals[name] for name in COMPARED if name in signals}))


def joint_message(stamp: int, signals: Mapping[str, float]) -> JointState:
    """Both shafts as joints, for standard tools: position [rad] and the motor's speed [rad/s]."""
    return JointState(
        header=header(stamp),
        name=["motor", "output"],
        position=[signals.get("motor_position", math.nan), signals.get("output_position", math.nan)],
        velocity=[signals.get("speed", math.nan), math.nan],
    )
