"""Definitions of ROS messages as text, from the installed packages; needs no ROS library."""

from __future__ import annotations

import json
import re
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from ema_bench_replay.configuration import checkout, share_folders
from ema_bench_replay.errors import InputError

_SEPARATOR = "=" * 80 + "\n"
_CONSTANT = re.compile(r"^[\w/<=\[\]]+\s+\w+\s*=")

# ROS definitions that our bags need, for machines without ROS.
_STANDARD = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    ),
}


class Definition(NamedTuple):
    """A type's description in a bag."""

    text: str  # the definition and its dependencies, joined as in MCAP's encoding ros2msg
    type_hash: str  # RIHS01_…, or empty if the package is not built


@lru_cache(maxsize=64)
def message_definition(type_name: str) -> Definition:
    """Definition of a type such as `std_msgs/msg/Header`. Raises InputError if its package is not found."""
    package, name = type_name.split("/")[0], type_name.split("/")[-1]
    own, source = _read(package, name)
    joined, waiting, known = own.rstrip() + "\n", _dependencies(own, package), {f"{package}/{name}"}
    while waiting:
        dependency = waiting.pop(0)
        if dependency in known:
            continue
        known.add(dependency)
        text, _ = _read(*dependency.split("/"))
        joined += f"{_SEPARATOR}MSG: {dependency}\n{text.rstrip()}\n"
        waiting += _dependencies(text, dependency.split("/")[0])
    return Definition(joined, _type_hash(source, f"{package}/msg/{name}"))


def _read(package: str, name: str) -> tuple[str, Path | None]:
    """Text of one definition, and its file (None: a standard one, from this module)."""
    places = [share / package / "msg" / f"{name}.msg" for share in share_folders()]
    if root := checkout():
        places.append(root / package / "msg" / f"{name}.msg")
    for place in places:
        if place.is_file():
            return place.read_text(encoding="utf-8"), place
    if text := _STANDARD.get(f"{package}/{name}"):
        return text, None
    tried = ", ".join(str(place.parent) for place in places)
    missing = f"{package}/msg/{name}: no such message is installed"
    raise InputError(f"{missing}; build or source its package (looked in {tried})")


def _dependencies(text: str, package: str) -> list[str]:
    """Types that a definition uses, as package/Name."""
    names = []
    for line in text.split("\n"):
        line = line.partition("#")[0].strip()
        if not line or _CONSTANT.match(line):
            continue
        kind = re.match(r"[\w/]+", line)
        if kind and (kind[0][0].isupper() or "/" in kind[0]):
            owner, _, name = kind[0].rpartition("/")
            names.append(f"{owner.split('/')[0] or package}/{name}")
    return names


def _type_hash(source: Path | None, type_name: str) -> str:
    """The hash that the build wrote next to the definition."""
    described = source.with_suffix(".json") if source else None
    if not described or not described.is_file():
        return ""
    hashes = json.loads(described.read_text(encoding="utf-8")).get("type_hashes", [])
    return next((entry["hash_string"] for entry in hashes if entry["type_name"] == type_name), "")
