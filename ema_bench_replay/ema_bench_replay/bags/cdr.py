"""ROS messages in bulk: the field offsets of a serialised message as a NumPy structure, from the type's definition.

ROS 2 serialises messages as CDR (OMG's XCDR 1): a header of four bytes, then the fields in order, each aligned to its
own size counted from the end of that header. If a message's strings and sequences have fixed lengths, so do the
offsets, and thousands of messages are read or written with one NumPy operation per field.
"""

from __future__ import annotations

import re
import struct
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

_HEADER = 4
_PRIMITIVES = {
    **{"bool": "u1", "byte": "u1", "char": "u1", "uint8": "u1", "int8": "i1", "uint16": "u2", "int16": "i2"},
    **{"uint32": "u4", "int32": "i4", "uint64": "u8", "int64": "i8", "float32": "f4", "float64": "f8"},
}
_LONGEST_DEFINITION = 1 << 20  # characters; message definitions have some hundred
_MOST_FIELDS = 100_000  # of one message, including nested messages
_FIELD = re.compile(
    r"(?P<type>[\w/]+)(?:<=\d+)?(?P<array>\[(?P<count>(?:<=)?\d*)\])?\s+(?P<name>\w+)(?P<constant>\s*=)?"
)


class CdrError(ValueError):
    """A definition that cannot be read, or a message that does not match its definition."""


@dataclass(frozen=True)
class Field:
    """One field of a message type."""

    name: str
    type: str  # a primitive, "string", or package/Name
    count: int | None = None  # None: single; -1: a sequence; otherwise an array of that length


Types = dict[str, list[Field]]


@dataclass(frozen=True)
class Layout:
    """Field offsets of a message for given lengths of its strings and sequences."""

    dtype: np.dtype  # of a whole message; names such as `header.stamp.sec`
    lengths: tuple[tuple[int, int], ...]  # of each string and sequence: the offset of its length, and that length


def parse(definition: str, type_name: str) -> tuple[Types, str]:
    """All types of a ros2msg definition text, and the key of the one it defines. Raises CdrError."""
    if len(definition) > _LONGEST_DEFINITION:
        raise CdrError("has a definition of more than 1 MiB")
    root = _short(type_name)
    types: Types = {}
    for position, part in enumerate(re.split(r"^=+$", definition, flags=re.MULTILINE)):
        owner = root
        if position:
            first, _, part = part.lstrip("\n").partition("\n")
            owner = _short(first.removeprefix("MSG:").strip())
        types[owner] = [field for line in part.split("\n") if (field := _field(line, owner.split("/")[0]))]
    return types, root


def layout_of(types: Types, root: str, message: bytes | memoryview) -> Layout:
    """Layout of one serialised message. Raises CdrError if the bytes do not match the type."""
    if len(message) < _HEADER or message[0] != 0 or message[1] not in (0, 1):
        raise CdrError("is not in plain CDR")
    order = "<" if message[1] else ">"
    read_length = struct.Struct(order + "I").unpack_from

    def length_at(offset: int) -> int:
        if offset + 4 > len(message):
            raise CdrError("is shorter than its type")
        length = read_length(message, offset)[0]
        if length > len(message):
            raise CdrError("is shorter than its type")
        return length

    walk = _Walk(types, order, length_at)
    try:
        walk.struct(root, "")
    except RecursionError:
        raise CdrError("has a type that contains itself") from None
    if walk.end > len(message):
        raise CdrError("is shorter than its type")
    return walk.layout(len(message))


def serialise(types: Types, root: str, values: Mapping[str, Any]) -> bytes:
    """Serialise one message from a (nested) mapping of its fields; missing fields are 0, NaN or empty."""
    out = bytearray(b"\x00\x01\x00\x00")
    _write_struct(out, types, root, values)
    return bytes(out)


def decode(
    types: Types, root: str, buffer: bytes, offsets: np.ndarray, sizes: np.ndarray, names: tuple[str, ...]
) -> dict[str, np.ndarray]:
    """Fields of many messages in one buffer; names that the type lacks are left out.

    Messages with the same lengths are read together, so a buffer takes one pass per different combination of lengths.

    Args:
        types: as `parse` gives them.
        root: key of the messages' type.
        buffer: the serialised messages.
        offsets: int64 (n,), where each begins.
        sizes: int64 (n,), bytes of each.
        names: names of fields that are single numbers, such as `header.stamp.sec`.

    Returns:
        For each name an array (n,).
    """
    result: dict[str, np.ndarray] = {}
    left = np.arange(len(offsets))
    while left.size:
        first = left[0]
        layout = layout_of(types, root, memoryview(buffer)[offsets[first] : offsets[first] + sizes[first]])
        alike = left[sizes[left] == sizes[first]]
        size = layout.dtype.itemsize
        # As opaque bytes: copying a structure field by field would lose the bytes between fields.
        every = np.ndarray((len(buffer) - size + 1,), f"V{size}", buffer, strides=(1,))  # one view begins at every byte
        opaque = every[offsets[alike]]
        messages, raw = opaque.view(layout.dtype), opaque.view(np.uint8).reshape(len(opaque), size)
        same = raw[:, 1] == raw[0, 1]
        order = "<" if raw[0, 1] else ">"
        for offset, length in layout.lengths:
            same &= np.ascontiguousarray(raw[:, offset : offset + 4]).view(f"{order}u4")[:, 0] == length
        if not same.all():
            alike, messages = alike[same], messages[same]
        for name in set(names).intersection(layout.dtype.names or ()):
            if layout.dtype[name].shape:
                raise CdrError(f"has several numbers as its {name}")
            if name not in result:
                result[name] = np.empty(len(offsets), layout.dtype[name].newbyteorder("="))
            result[name][alike] = messages[name]
        left = np.setdiff1d(left, alike, assume_unique=True)
    return result


class _Walk:
    """Walks through a type field by field and records the offsets."""

    def __init__(self, types: Types, order: str, length_at: Callable[[int], int]) -> None:
        self.types, self.order, self.length_at = types, order, length_at
        self.end = _HEADER
        self.visited = 0
        self.names: list[str] = []
        self.formats: list[Any] = []
        self.offsets: list[int] = []
        self.lengths: list[tuple[int, int]] = []

    def layout(self, size: int) -> Layout:
        twice = next((name for name, count in Counter(self.names).items() if count > 1), None)
        if twice is not None:
            raise CdrError(f"has the field {twice} twice")
        parts: Any = {"names": self.names, "formats": self.formats, "offsets": self.offsets, "itemsize": size}
        return Layout(np.dtype(parts), tuple(self.lengths))

    def struct(self, name: str, path: str) -> None:
        if name not in self.types:
            raise CdrError(f"uses the type {name}, which its definition lacks")
        for field in self.types[name]:
            self.visit()
            here = f"{path}{field.name}"
            if field.count is None:
                self.value(field.type, here)
                continue
            count = self.length() if field.count < 0 else field.count
            if field.type in _PRIMITIVES:
                if count:
                    self.place(here, _PRIMITIVES[field.type], count)
            else:
                for index in range(count):
                    self.visit()
                    self.value(field.type, f"{here}[{index}]")

    def visit(self) -> None:
        self.visited += 1
        if self.visited > _MOST_FIELDS:
            raise CdrError(f"has more than {_MOST_FIELDS} fields")

    def value(self, kind: str, path: str) -> None:
        if kind in _PRIMITIVES:
            self.place(path, _PRIMITIVES[kind], None)
        elif kind == "string":
            length = self.length()
            self.end += length
        else:
            self.struct(kind, f"{path}.")

    def length(self) -> int:
        self.align(4)
        length = self.length_at(self.end)
        self.lengths.append((self.end, length))
        self.end += 4
        return length

    def place(self, path: str, code: str, count: int | None) -> None:
        size = int(code[1])
        self.align(size)
        self.names.append(path)
        self.formats.append(f"{self.order}{code}" if count is None else (f"{self.order}{code}", (count,)))
        self.offsets.append(self.end)
        self.end += size * (1 if count is None else count)

    def align(self, size: int) -> None:
        self.end += -(self.end - _HEADER) % size


def _write_struct(out: bytearray, types: Types, name: str, values: Mapping[str, Any]) -> None:
    for field in types[name]:
        value = values.get(field.name)
        if field.count is None:
            _write_value(out, types, field.type, value)
            continue
        items = list(value) if value is not None else [None] * max(field.count, 0)
        if field.count < 0:
            _write_number(out, "u4", len(items))
        for item in items:
            _write_value(out, types, field.type, item)


def _write_value(out: bytearray, types: Types, kind: str, value: Any) -> None:
    if kind in _PRIMITIVES:
        code = _PRIMITIVES[kind]
        _write_number(out, code, value if value is not None else np.nan if code[0] == "f" else 0)
    elif kind == "string":
        text = (value or "").encode() + b"\0"
        _write_number(out, "u4", len(text))
        out += text
    else:
        _write_struct(out, types, kind, value or {})


def _write_number(out: bytearray, code: str, value: Any) -> None:
    out += b"\0" * (-(len(out) - _HEADER) % int(code[1]))
    out += np.array(value, dtype=f"<{code}").tobytes()


def _field(line: str, package: str) -> Field | None:
    line = line.partition("#")[0].strip()
    if not line:
        return None
    match = _FIELD.match(line)
    if not match:
        raise CdrError(f"has a definition with the line {line!r}, which is not understood")
    if match["constant"]:
        return None
    kind = match["type"]
    if kind == "wstring":
        raise CdrError("has a wstring, which is not supported")
    if kind not in _PRIMITIVES and kind != "string":
        kind = _short(kind) if "/" in kind else f"{package}/{kind}"
    if match["array"] is None:
        return Field(match["name"], kind)
    count = match["count"]
    return Field(match["name"], kind, int(count) if count.isdigit() else -1)


def _short(type_name: str) -> str:
    """package/Name of package/msg/Name."""
    parts = type_name.split("/")
    return f"{parts[0]}/{parts[-1]}"
