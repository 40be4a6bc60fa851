"""Encode and decode the messages of every sample, EmaState and Residual, as serialised bytes.

ROS sets unset fields to 0.0, which reads as a measurement; here they are NaN.

Publishers and subscriptions of these types use serialised messages (`publish(bytes)`, `raw=True`): rclpy's conversion
to a Python object with 21 checked properties takes 11 µs each way, this one 1 µs. Most of the tenth of a core that a
node takes at 500 Hz is spent waking up, which cannot be avoided; this can.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from functools import lru_cache
from operator import attrgetter

from rclpy.serialization import deserialize_message

from ema_bench_replay.sample import State
from ema_twin_msgs.msg import EmaState, Signals

FIELDS = tuple(name for name, kind in EmaState.get_fields_and_field_types().items() if kind == "double")
"""Names of the float fields of an EmaState, in its order: the signals, and the two angle origins."""
COMPARED = tuple(Signals.get_fields_and_field_types())
"""Names of the signals that bench and twin are compared in, in the order of a Residual."""

_UNKNOWN = dict.fromkeys(FIELDS, math.nan)
_values = attrgetter(*FIELDS)

# Plain CDR: a header of four bytes, then the fields, each aligned to its size counted from the end of the header.
_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_ORDERS = {0: ">", 1: "<"}


@lru_cache(maxsize=64)
def _layout(order: str, frame_id: int, floats: int) -> struct.Struct:
    """sec, nanosec, length of frame_id, run, sequence, floats; `frame_id` is its length including the final zero."""
    before_run = -frame_id % 4
    before_sequence = -(12 + frame_id + before_run + 4) % 8
    return struct.Struct(f"{order}iII{frame_id + before_run}xI{before_sequence}xQ{floats}d")


_state = _layout("<", 1, len(FIELDS))
_residual = _layout("<", 1, len(COMPARED))


def write_state(stamp: int, run: int, sequence: int, signals: Mapping[str, float]) -> bytes:
    """A serialised EmaState of these signals (SI), stamped in ns since the epoch; other fields are NaN."""
    seconds, nanoseconds = divmod(stamp, 1_000_000_000)
    return _LITTLE_ENDIAN + _state.pack(seconds, nanoseconds, 1, run, sequence, *{**_UNKNOWN, **signals}.values())


def write_residual(stamp: int, run: int, sequence: int, residuals: Mapping[str, float]) -> bytes:
    """A serialised Residual: all compared signals (SI, NaN where unknown), stamped in ns since the epoch."""
    seconds, nanoseconds = divmod(stamp, 1_000_000_000)
    values = [residuals[name] for name in COMPARED]
    return _LITTLE_ENDIAN + _residual.pack(seconds, nanoseconds, 1, run, sequence, *values)


def read_state(message: bytes) -> State:
    """Decode a serialised EmaState from any writer."""
    order = _ORDERS.get(message[1]) if message[0] == 0 else None
    if order is None:  # not plain CDR
        return _by_ros(message)
    (frame_id,) = struct.unpack_from(f"{order}I", message, 12)
    seconds, nanoseconds, _, run, sequence, *values = _layout(order, frame_id, len(FIELDS)).unpack_from(message, 4)
    return State(run, sequence, seconds * 1_000_000_000 + nanoseconds, dict(zip(FIELDS, values, strict=True)))


def _by_ros(message: bytes) -> State:
    state = deserialize_message(message, EmaState)
    stamp = state.header.stamp.sec * 1_000_000_000 + state.header.stamp.nanosec
    return State(state.run, state.sequence, stamp, dict(zip(FIELDS, _values(state), strict=True)))
