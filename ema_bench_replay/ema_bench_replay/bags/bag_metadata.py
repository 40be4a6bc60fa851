"""Metadata that rosbag2 needs in addition to the messages: QoS profiles, and the folder's metadata.yaml as in Jazzy."""

from __future__ import annotations

import json
from collections.abc import Sequence
from textwrap import indent
from typing import NamedTuple

_INFINITE = "\n    sec: 9223372036\n    nsec: 854775807"


class Topic(NamedTuple):
    """One topic of a bag."""

    name: str
    type_name: str
    type_hash: str
    qos: str
    messages: int


def qos_profile(*, reliability: str, durability: str, history: str = "keep_last", depth: int = 10) -> str:
    """One QoS profile as rosbag2 writes it (YAML), in the words of `ros2 topic pub --help`."""
    return (
        f"- history: {history}\n  depth: {depth}\n  reliability: {reliability}\n  durability: {durability}\n"
        f"  deadline:{_INFINITE}\n  lifespan:{_INFINITE}\n  liveliness: automatic\n"
        f"  liveliness_lease_duration:{_INFINITE}\n  avoid_ros_namespace_conventions: false"
    )


#: QoS with which the nodes publish these topics.
STATE_QOS = qos_profile(reliability="reliable", durability="transient_local", history="keep_all", depth=0)
JOINTS_QOS = qos_profile(reliability="reliable", durability="volatile")


class FileOfBag(NamedTuple):
    """One file of a bag."""

    name: str
    first: int  # ns since the epoch: log time of the first message
    last: int
    messages: int


def metadata_yaml(files: Sequence[FileOfBag], topics: Sequence[Topic]) -> str:
    """Text of metadata.yaml for a bag of these files, in the order in which they are played."""
    held = [file for file in files if file.messages] or files[:1]
    first, last = min((file.first for file in held), default=0), max((file.last for file in held), default=0)
    names = [json.dumps(file.name) for file in files]  # quoted, since a file may be called anything
    listed = "".join(
        f"- path: {name}\n{indent(_span(file.first, file.last, file.messages), '  ')}"
        for name, file in zip(names, files, strict=True)
    )
    return (
        "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n"
        + indent(_span(first, last, sum(file.messages for file in files)), "  ")
        + f"  topics_with_message_count:{_listed(''.join(_topic(topic) for topic in topics))}"
        + '  compression_format: ""\n  compression_mode: ""\n'
        + f"  relative_file_paths:{_listed(''.join(f'- {name}' + chr(10) for name in names))}"
        + f"  files:{_listed(listed)}"
        + "  custom_data: ~\n  ros_distro: jazzy\n"
    )


def _listed(lines: str) -> str:
    return "\n" + indent(lines, "    ") if lines else " []\n"


def _span(first: int, last: int, messages: int) -> str:
    return (
        f"starting_time:\n  nanoseconds_since_epoch: {first}\nduration:\n  nanoseconds: {last - first}\n"
        f"message_count: {messages}\n"
    )


def _topic(topic: Topic) -> str:
    profiles = f"\n{indent(topic.qos, '      ')}" if topic.qos else " []"
    return (
        f"- topic_metadata:\n    name: {topic.name}\n    type: {topic.type_name}\n    serialization_format: cdr\n"
        f"    offered_qos_profiles:{profiles}\n"
        f'    type_description_hash: "{topic.type_hash}"\n  message_count: {topic.messages}\n'
    )
