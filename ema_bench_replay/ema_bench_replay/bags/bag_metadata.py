"""What rosbag2 wants beside the messages: QoS profiles, and the folder's metadata.yaml as Jazzy writes it."""

from __future__ import annotations

import json
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


#: As the nodes publish these topics.
STATE_QOS = qos_profile(reliability="reliable", durability="transient_local", history="keep_all", depth=0)
JOINTS_QOS = qos_profile(reliability="reliable", durability="volatile")


def metadata_yaml(file: str, first: int, last: int, topics: list[Topic]) -> str:
    """Text of metadata.yaml for a bag of one file whose messages span from `first` to `last` (ns)."""
    count = sum(topic.messages for topic in topics)
    span = (
        f"starting_time:\n  nanoseconds_since_epoch: {first}\nduration:\n  nanoseconds: {last - first}\n"
        f"message_count: {count}\n"
    )
    name = json.dumps(file)  # quoted, since a file may be called anything
    listed = "".join(_topic(topic) for topic in topics)
    return (
        "rosbag2_bagfile_information:\n  version: 9\n  storage_identifier: mcap\n"
        + indent(span, "  ")
        + "  topics_with_message_count:\n"
        + indent(listed, "    ")
        + '  compression_format: ""\n  compression_mode: ""\n'
        + f"  relative_file_paths:\n    - {name}\n  files:\n    - path: {name}\n"
        + indent(span, "      ")
        + "  custom_data: ~\n  ros_distro: jazzy\n"
    )


def _topic(topic: Topic) -> str:
    profiles = f"\n{indent(topic.qos, '      ')}" if topic.qos else " []"
    return (
        f"- topic_metadata:\n    name: {topic.name}\n    type: {topic.type_name}\n    serialization_format: cdr\n"
        f"    offered_qos_profiles:{profiles}\n"
        f'    type_description_hash: "{topic.type_hash}"\n  message_count: {topic.messages}\n'
    )
