"""Samples as bytes: what ROS itself writes and reads, in either byte order, with any frame name, NaN where unknown."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Header

from ema_bench_replay.nodes.sample_codec import COMPARED, FIELDS, read_state, write_residual, write_state
from ema_bench_replay.sample import VALUES
from ema_twin_msgs.msg import EmaState, Residual

floats = st.floats(allow_nan=False)
stamps = st.integers(0, 2**31 * 10**9 - 1)


def test_fields_are_the_signals_of_a_recording_and_the_origins():
    names = list(EmaState.get_fields_and_field_types())
    assert names[:3] == ["header", "run", "sequence"]
    assert tuple(names[3:]) == FIELDS
    told = "EmaState.msg and units.py differ, or `make setup` is to be run"
    assert set(FIELDS) == {*VALUES}, told


@given(stamps, st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1), st.dictionaries(st.sampled_from(FIELDS), floats))
def test_ros_reads_what_is_written(stamp, run, sequence, signals):
    message = deserialize_message(write_state(stamp, run, sequence, signals), EmaState)
    assert (message.run, message.sequence, message.header.frame_id) == (run, sequence, "")
    assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
    for name in FIELDS:
        value = getattr(message, name)
        assert value == signals[name] if name in signals else math.isnan(value)


@given(st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=30), st.integers(0, 2**64 - 1), floats)
def test_what_ros_writes_is_read(frame_id, sequence, current):
    message = EmaState(header=Header(frame_id=frame_id), run=7, sequence=sequence, current=current)
    message.header.stamp.sec, message.header.stamp.nanosec = 5, 9
    state = read_state(serialize_message(message))
    assert (state.run, state.sequence, state.stamp) == (7, sequence, 5_000_000_009)
    assert state.signals == dict.fromkeys(FIELDS, 0.0) | {"current": current}


@given(
    stamps, st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1), st.fixed_dictionaries(dict.fromkeys(COMPARED, floats))
)
def test_ros_reads_a_residual(stamp, run, sequence, residuals):
    message = deserialize_message(write_residual(stamp, run, sequence, residuals), Residual)
    assert (message.run, message.sequence) == (run, sequence)
    assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
    assert {name: getattr(message.residual, name) for name in COMPARED} == residuals


def test_the_other_byte_order_is_read():
    values = [float(n) for n in range(len(FIELDS))]
    message = b"\0\0\0\0" + struct.pack(f">iIIB3xI4xQ{len(values)}d", 1, 2, 1, 0, 3, 4, *values)
    assert read_state(message) == (3, 4, 1_000_000_002, dict(zip(FIELDS, values, strict=True)))


def test_a_field_that_there_is_not_is_refused():
    with pytest.raises(struct.error):
        write_state(0, 0, 0, {"curent": 1.0})
