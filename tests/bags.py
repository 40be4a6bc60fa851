"""Recordings and bags that tests make, as this project and as other tools write them."""

import math
from contextlib import contextmanager

import numpy as np
import yaml
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from ema_bench_replay.bags.bag_reader import read_bag
from ema_bench_replay.bags.cdr import parse, serialise
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.recording import Recording
from tests.one_line import refused_in_one_line

STATE = "ema_twin_msgs/msg/EmaState"
DEFINITION = message_definition(STATE).text


def a_recording(samples=1200, name="run", **changes):
    stamps = np.arange(samples) * 2_000_000
    random = np.random.default_rng(1)
    names = ("current", "speed", "motor_position", "output_position")
    parts = {
        "stamps": stamps,
        "signals": {signal: random.normal(size=samples) for signal in names},
        "start": 1_713_350_000_123_456_789,
        "motor_angle_origin": -math.pi,
        "output_angle_origin": 1.25,
        "metadata": {"source": "run.CSV", "map_text": "a: 1\nb: ü\n"},
        "warnings": ("run.CSV: a first thing", "run.CSV: a second one"),
    }
    return Recording(name, **{**parts, **changes})


def assert_same(one, other):
    assert one.name == other.name and one.start == other.start and np.array_equal(one.stamps, other.stamps)
    assert list(one.signals) == list(other.signals)
    for name, values in one.signals.items():
        assert values.tobytes() == other.signals[name].tobytes(), name
    origins = [(r.motor_angle_origin, r.output_angle_origin) for r in (one, other)]
    assert np.array_equal(*origins, equal_nan=True)
    assert one.metadata == other.metadata and one.warnings == other.warnings


def summary_of(path):
    """The summary of a finished bag's file, as the library reads it."""
    with path.open("rb") as file:
        return make_reader(file).get_summary()


def listed_in(folder):
    """The content of a bag's metadata.yaml."""
    return yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]


def refused(path, *words, topic=None):
    with refused_in_one_line(path, *words):
        read_bag(path, topic=topic)


def write_other(
    path, samples, *, definition=DEFINITION, compression=CompressionType.NONE, chunked=True, topic="/bench/state"
):
    """A bag as another tool may write it: one call a message, `samples` of fields and log times."""
    options = {"compression": compression, "use_chunking": chunked, "chunk_size": 4096}
    with other_writer(path, definition, topic, **options) as (writer, channel):
        for content, log_time in serialised(samples, definition):
            writer.add_message(channel, log_time, content, log_time)
    return path


@contextmanager
def other_writer(path, definition=DEFINITION, topic="/bench/state", **options):
    """The library's writer of a bag with one topic of states, and the channel of that; it is finished at the end."""
    with path.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="ros2")
        schema = writer.register_schema(STATE, "ros2msg", definition.encode())
        yield writer, writer.register_channel(topic, "cdr", schema, {"offered_qos_profiles": ""})
        writer.finish()


def serialised(samples, definition=DEFINITION):
    """Samples of fields and log times as messages and log times."""
    types, root = parse(definition, STATE)
    for values, log_time in samples:
        stamp = dict(zip(("sec", "nanosec"), divmod(values["stamp"], 10**9), strict=True))
        header = {"stamp": stamp, "frame_id": values.get("frame_id", "")}
        yield serialise(types, root, {**values, "header": header}), log_time


def some_samples(count=50, **fields):
    return [
        ({"stamp": 10**9 + k * 10**6, "run": 3, "sequence": k, "current": k / 7, "speed": -k / 3, **fields}, 10**9 + k)
        for k in range(count)
    ]
