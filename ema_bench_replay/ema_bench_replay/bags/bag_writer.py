"""Write recordings as bags: an MCAP that `ros2 bag`, Foxglove, PlotJuggler and rerun open directly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from mcap.opcode import Opcode

from ema_bench_replay.bags.bag_metadata import JOINTS_QOS, STATE_QOS, FileOfBag, Topic, metadata_yaml
from ema_bench_replay.bags.cdr import layout_of, parse, serialise
from ema_bench_replay.bags.definitions import message_definition
from ema_bench_replay.bags.mcap_file import MESSAGE_PREFIX, PREFIX_UNCOUNTED, McapFile, Messages
from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import release_pages
from ema_bench_replay.outputs import new_file, write_text
from ema_bench_replay.recording import Recording

STATE_TOPIC, STATE_TYPE = "/bench/state", "ema_twin_msgs/msg/EmaState"
JOINTS_TOPIC, JOINTS_TYPE = "/bench/joint_states", "sensor_msgs/msg/JointState"
#: Name of the MCAP metadata record that holds a recording's own metadata.
METADATA_NAME = "ema_twin"

_CHUNK = 1_000_000_000  # ns
_JOINTS_PERIOD = 10_000_000  # ns
_BLOCK = 20_000  # rows encoded at a time


def write_bag(recording: Recording, directory: str | Path, *, force: bool = False) -> Path:
    """Write a recording as DIRECTORY/NAME/NAME.mcap with its metadata.yaml; returns that folder.

    An interrupted call leaves no partial file. Raises InputError if the bag exists (without `force`) or cannot be
    written.
    """
    folder = Path(directory) / recording.name
    file = folder / f"{recording.name}.mcap"
    index = folder / "metadata.yaml"
    if not force and index.exists():
        raise InputError(f"{folder}: holds a bag already; choose another folder with -o, or --force to replace it")
    with new_file(file, force=force) as stream:
        text = _write(recording, stream, file.name)
    write_text(index, text, force=True)
    return folder


def write_mcap(recording: Recording, path: str | Path, *, force: bool = False) -> None:
    """Write a recording as one MCAP file of that name, without rosbag2's folder."""
    with new_file(Path(path), force=force) as stream:
        _write(recording, stream, Path(path).name)


def _write(recording: Recording, stream: BinaryIO, name: str) -> str:
    """Write the MCAP; returns the text of metadata.yaml."""
    file = McapFile(stream)
    file.add_metadata(METADATA_NAME, _metadata(recording))
    state_topic = Topic(STATE_TOPIC, STATE_TYPE, STATE_QOS)
    state = encoder_of(file, state_topic, {"header": {"frame_id": "bench"}, "run": 1})
    encoders = [state]
    joints = {"motor": "motor_position", "output": "output_position"}
    joints = {joint: signal for joint, signal in joints.items() if recording.has(signal)}
    if joints:
        zeros = [0.0] * len(joints)
        example = {"name": list(joints), "position": zeros, "velocity": zeros, "header": {"frame_id": "bench"}}
        encoders.append(encoder_of(file, Topic(JOINTS_TOPIC, JOINTS_TYPE, JOINTS_QOS), example))
    for start, end in _blocks(recording.stamps):
        samples, stamps = np.arange(start, end), recording.stamps[start:end] + recording.start
        blocks = [(state, state.encode(stamps, samples, _state_columns(recording, samples)))]
        if joints:
            slots = recording.stamps[max(start - 1, 0) : end] // _JOINTS_PERIOD
            some = samples[np.diff(slots, prepend=slots[:0] if start else -1) != 0]
            columns = _joint_columns(recording, joints, some)
            blocks.append((encoders[1], encoders[1].encode(stamps[some - start], some, columns)))
        for chunk in chunks(blocks, recording.start):
            file.add_chunk(chunk)
        release_pages()
    file.finish()
    topics = {encoder.topic: file.counts[encoder.channel] for encoder in encoders}
    return metadata_yaml([FileOfBag(name, *file.span, sum(topics.values()))], topics)


class Encoder(NamedTuple):
    """Makes the message records of one topic, which differ only in their numbers."""

    topic: Topic
    channel: int
    dtype: np.dtype  # of a record: prefix and message
    blank: bytes  # a record with all constant parts

    def encode(self, stamps: np.ndarray, sequence: np.ndarray, columns: Mapping[str, np.ndarray | float]) -> np.ndarray:
        """Records (m,) at these stamps (m,), ns since the epoch, with these values in their fields."""
        records = np.frombuffer(bytearray(self.blank) * len(stamps), self.dtype)
        prefix, message = records["prefix"], records["message"]
        prefix["log_time"] = prefix["publish_time"] = stamps
        prefix["sequence"] = sequence
        message["header.stamp.sec"], message["header.stamp.nanosec"] = np.divmod(stamps, 1_000_000_000)
        for name, values in columns.items():
            message[name] = values
        return records


def encoder_of(file: McapFile, topic: Topic, example: dict[str, Any]) -> Encoder:
    """Add a topic to a file; its messages have the lengths and the constant parts of an example."""
    channel = file.add_channel(topic)
    types, root = parse(message_definition(topic.type_name).text, topic.type_name)
    message = serialise(types, root, example)
    dtype = np.dtype([("prefix", MESSAGE_PREFIX), ("message", layout_of(types, root, message).dtype)])
    blank = np.zeros(1, dtype)
    blank["prefix"]["opcode"] = Opcode.MESSAGE
    blank["prefix"]["length"] = dtype.itemsize - PREFIX_UNCOUNTED
    blank["prefix"]["channel"] = channel
    return Encoder(topic, channel, dtype, blank["prefix"].tobytes() + message)


def _state_columns(recording: Recording, samples: np.ndarray) -> dict[str, np.ndarray | float]:
    """Fields of EmaState; others stay NaN."""
    signals = {name: values[samples] for name, values in recording.signals.items()}
    return {"sequence": samples, **signals, **recording.origins}


def _joint_columns(recording: Recording, joints: dict[str, str], samples: np.ndarray) -> dict[str, np.ndarray]:
    """Fields of JointState. Only the motor's speed is measured; the output's is unknown."""
    unknown = np.full(len(samples), np.nan)
    motor = recording.signals["speed"][samples] if recording.has("speed") else unknown
    speeds = {"motor": motor, "output": unknown}
    return {
        "position": np.column_stack([recording.signals[signal][samples] for signal in joints.values()]),
        "velocity": np.column_stack([speeds[joint] for joint in joints]),
    }


def _blocks(stamps: np.ndarray) -> Iterator[tuple[int, int]]:
    """Row ranges (end exclusive) of blocks that end at the end of a chunk."""
    start = 0
    while start < len(stamps):
        end = min(start + _BLOCK, len(stamps))
        if end < len(stamps):
            # as many whole chunks as fit, or a single larger one
            chunk = stamps[end] // _CHUNK
            first, beyond = (int(row) for row in np.searchsorted(stamps, (chunk * _CHUNK, (chunk + 1) * _CHUNK)))
            end = first if first > start else beyond
        yield start, end
        start = end


def chunks(blocks: Sequence[tuple[Encoder, np.ndarray]], start: int = 0) -> Iterator[list[Messages]]:
    """The records of each topic in a block, cut into chunks of one second, counted from `start` [ns]."""
    seconds = [(records["prefix"]["log_time"].astype(np.int64) - start) // _CHUNK for _, records in blocks]
    for second in np.unique(np.concatenate([*seconds, np.zeros(0, np.int64)])):
        chunk = []
        for (encoder, records), of_record in zip(blocks, seconds, strict=True):
            low, high = np.searchsorted(of_record, (second, second + 1))
            if low < high:
                part = records[low:high]
                offsets = np.arange(high - low) * records.dtype.itemsize
                chunk.append(Messages(encoder.channel, part["prefix"]["log_time"], offsets, part.tobytes()))
        yield chunk


def _metadata(recording: Recording) -> dict[str, str]:
    return {
        **recording.metadata,
        "signals": " ".join(recording.signals),
        **{name: repr(origin) for name, origin in recording.origins.items()},
        "warnings": "\n".join(recording.warnings),
    }
