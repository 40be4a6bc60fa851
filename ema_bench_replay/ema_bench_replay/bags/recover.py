"""Recover an unfinished or damaged bag: write its readable part, with an index."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from mcap.writer import Writer

from ema_bench_replay.bags.mcap_scan import McapScan
from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import new_file


class RecoveredTopic(NamedTuple):
    """What was recovered of one topic."""

    messages: int
    seconds: float  # from the first message to the last


@dataclass(frozen=True)
class Recovered:
    """What was recovered from a damaged bag."""

    topics: dict[str, RecoveredTopic]
    damage: str | None  # in words; None if the bag was complete
    torn: int  # bytes after the last complete record

    @property
    def messages(self) -> dict[str, int]:
        """Messages by topic."""
        return {name: topic.messages for name, topic in self.topics.items()}

    @property
    def seconds(self) -> float:
        """The longest span of a topic, s."""
        return max(topic.seconds for topic in self.topics.values())


def recover(path: Path, output: Path, *, force: bool = False) -> Recovered:
    """Write all messages of the MCAP at ``path`` to ``output``, up to the damage; the original is not changed.

    Raises InputError if no message can be recovered, or the output cannot be written.
    """
    if output.suffix.lower() != ".mcap":
        raise InputError(f"{output}: is no name of a bag; give FILE.mcap")
    if output.exists() and output.samefile(path):
        raise InputError(f"{output}: is the damaged bag itself, which stays; give another name")
    scan = McapScan(path)
    times: dict[str, tuple[int, int, int]] = {}  # per topic: messages, first and last log time
    with new_file(output, force=force) as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="ema_bench_replay")
        written: dict[int, int] = {}  # channels by their number in the original
        schemas: dict[int, int] = {0: 0}  # schema 0 means none
        for message in scan.messages():
            if message.channel not in written:
                channel = scan.channels[message.channel]
                if channel.schema_id not in schemas and (schema := scan.schemas.get(channel.schema_id)):
                    schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
                written[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas.get(channel.schema_id, 0), channel.metadata
                )
            writer.add_message(
                written[message.channel], message.log_time, message.data, message.publish_time, message.sequence
            )
            logged = message.log_time
            count, first, last = times.get(scan.channels[message.channel].topic, (0, logged, logged))
            times[scan.channels[message.channel].topic] = count + 1, min(first, logged), max(last, logged)
        if not times:
            raise InputError(f"{path}: {scan.damage or 'holds no message'}; nothing of it can be recovered")
        for record in scan.metadata:
            writer.add_metadata(record.name, record.metadata)
        writer.finish()
    topics = {name: RecoveredTopic(n, (last - first) * 1e-9) for name, (n, first, last) in sorted(times.items())}
    return Recovered(topics, scan.damage, scan.torn)
