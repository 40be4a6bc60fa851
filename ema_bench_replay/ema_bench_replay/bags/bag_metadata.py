"""Metadata that rosbag2 needs in addition to the messages: QoS profiles, and the folder's metadata.yaml as in Jazzy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import yaml

from ema_bench_replay.bags.definitions import message_definition

_INFINITE = "\n    sec: 9223372036\n    nsec: 854775807"


class Topic(NamedTuple):
    """One topic of a bag."""

    name: str
    type_name: str
    qos: str  # rosbag2's offered_qos_profiles (YAML): one or several


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


def metadata_yaml(files: Sequence[FileOfBag], topics: Mapping[Topic, int]) -> str:
    """Text of metadata.yaml for a bag of these files, in the order in which they are played, and messages by topic."""
    held = [file for file in files if file.messages] or files[:1]
    first, last = min((file.first for file in held), default=0), max((file.last for file in held), default=0)
    information = {
        "version": 9,
        "storage_identifier": "mcap",
        **_span(first, last, sum(file.messages for file in files)),
        "topics_with_message_count": [_described(topic, count) for topic, count in topics.items()],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.name for file in files],
        "files": [{"path": file.name, **_span(file.first, file.last, file.messages)} for file in files],
        "custom_data": None,
        "ros_distro": "jazzy",
    }
    content = {"rosbag2_bagfile_information": information}
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=math.inf)


def _span(first: int, last: int, messages: int) -> dict[str, Any]:
    return {
        "starting_time": {"nanoseconds_since_epoch": first},
        "duration": {"nanoseconds": last - first},
        "message_count": messages,
    }


def _described(topic: Topic, messages: int) -> dict[str, Any]:
    described = {
        "name": topic.name,
        "type": topic.type_name,
        "serialization_format": "cdr",
        "offered_qos_profiles": yaml.safe_load(topic.qos) or [],
        "type_description_hash": message_definition(topic.type_name).type_hash,
    }
    return {"topic_metadata": described, "message_count": messages}
