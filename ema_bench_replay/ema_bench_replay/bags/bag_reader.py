"""Read bags as recordings: the EmaState messages of an MCAP from any writer."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from mcap.records import Schema

from ema_bench_replay.bags.bag_parts import bag_parts, how_to_convert, name_of
from ema_bench_replay.bags.bag_writer import METADATA_NAME, STATE_TOPIC, STATE_TYPE
from ema_bench_replay.bags.cdr import CdrError, Types, decode, parse
from ema_bench_replay.bags.mcap_scan import Block, McapScan
from ema_bench_replay.bags.packed_messages import unpacked
from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import Column, by_pieces, overlapping, pieces, shifted, steps_where, values_at
from ema_bench_replay.recording import ANGLE_ORIGINS, SIGNALS, Recording

_STAMP = ("header.stamp.sec", "header.stamp.nanosec")
_NAMES = (*_STAMP, "run", "sequence", *SIGNALS)
# Keys that `bag_writer` adds to a recording's own metadata.
_WRITTEN = ("signals", "warnings", *ANGLE_ORIGINS)
_NAMED = 5  # maximum number of topics that an error lists
_EVIDENCE = "/evidence/"  # prefix of the topics of a search's evidence


def read_bag(
    path: str | Path | Sequence[Path],
    *,
    topic: str | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Recording:
    """Read the EmaState messages of one topic: `topic`, otherwise /bench/state, otherwise the only one there is.

    `path` is an MCAP, a folder with one recording, or the files of a split one, in order. The samples are those of the
    first run in the bag, ordered by sequence (by stamp if they have none); repeated ones are dropped. A signal that is
    NaN throughout is absent; one that is NaN in places is refused, except unexplained_torque, which a twin may not know
    at once. A damaged file is used up to the damage. Warnings report what was left out. `progress` is called with the
    share of bytes read so far. Raises InputError.
    """
    files = _files(Path(path)) if isinstance(path, (str, Path)) else tuple(path)
    place = files[0] if len(files) == 1 else files[0].with_name(f"{files[0].name} to {files[-1].name}")
    scans = [McapScan(file) for file in files]
    topic, schema, types = _choose(place, scans, topic)
    columns = _read(scans, topic, schema, types, progress)
    damaged = [scan for scan in scans if scan.damage]
    warnings = [f"{scan.path.name}: {scan.damage}, so only what is before that can be used" for scan in damaged]
    if not columns:
        where = " before the damage" if damaged else ""
        raise InputError(f"{place}: {topic} has no samples{where}; record it again")
    samples = _Samples(place, name_of(files), topic, columns)
    samples.first_run()
    samples.in_order()
    own: dict[str, str] = {}
    for record in (record for scan in scans for record in scan.metadata):
        if record.name == METADATA_NAME:
            own.update(record.metadata)
    # Findings of the import belong to the bench's own signals.
    found = own.get("warnings", "") if topic == STATE_TOPIC else ""
    return samples.recording(
        metadata={key: value for key, value in own.items() if key not in _WRITTEN},
        warnings=[*found.splitlines(), *warnings, *samples.warnings],
    )


def _files(path: Path) -> tuple[Path, ...]:
    if not path.is_dir():
        return (path,)
    found = bag_parts(path)
    if len(found) == 1:
        return found[0]
    if not found and (other := how_to_convert(path)):
        raise InputError(f"{path}: {other}")
    if not found:
        raise InputError(f"{path}: the folder holds no .mcap and no CSV trace; give a file, or the folder of one bag")
    files = sorted(file.name for parts in found for file in parts)
    raise InputError(f"{path}: the folder holds {len(files)} .mcap files; name one of them: {', '.join(files)}")


def _some(names: Collection[str]) -> str:
    """The first few of these names, and the number of others."""
    first, others = sorted(names)[:_NAMED], len(names) - _NAMED
    return f"{', '.join(first)} and {others} more" if others > 0 else ", ".join(first)


def _state_channels(scan: McapScan) -> dict[int, tuple[str, Schema]]:
    """The channels of one file that carry EmaState, with topic and definition of each."""
    found = {}
    for channel in scan.channels.values():
        schema = scan.schemas.get(channel.schema_id)
        if schema and schema.name == STATE_TYPE and channel.message_encoding == "cdr" and schema.encoding == "ros2msg":
            found[channel.id] = channel.topic, schema
    return found


def _choose(place: Path, scans: Sequence[McapScan], topic: str | None) -> tuple[str, Schema, Types]:
    """The topic to read, its definition, and the types used in its messages."""
    topics: dict[str, Schema] = {}
    others = set()
    for scan in scans:
        of_state = _state_channels(scan)
        for name, schema in of_state.values():
            topics.setdefault(name, schema)
        for channel in scan.channels.values():
            if channel.id not in of_state:
                other = scan.schemas.get(channel.schema_id)
                others.add(f"{channel.topic} ({other.name if other else 'no type'})")
    if not topics:
        if not others:
            wrong = next((scan.damage for scan in scans if scan.damage), "the file is empty")
            raise InputError(f"{place}: {wrong}, no topic is left; record it again")
        if any(topic.startswith(_EVIDENCE) for topic in others):
            what = "is evidence that discover or diagnose wrote, no recording"
            raise InputError(f"{place}: {what}; open it with: rerun {place}")
        seen = _some(others)
        raise InputError(f"{place}: holds no {STATE_TYPE}, but {seen}; give a bag of /bench/state, or a CSV trace")
    if topic is None:
        topic = STATE_TOPIC if STATE_TOPIC in topics else next(iter(topics))
        if len(topics) > 1 and topic != STATE_TOPIC:
            one = f"ema-twin import {place} --topic {next(iter(topics))}"
            raise InputError(f"{place}: holds {_some(topics)} and no {STATE_TOPIC}; take one topic: {one}")
    if topic not in topics:
        raise InputError(f"{place}: holds no {STATE_TYPE} on {topic}; there is {_some(topics)}")
    schema = topics[topic]
    try:
        types, root = parse(schema.data.decode("utf-8", errors="replace"), schema.name)
    except CdrError as error:
        raise InputError(f"{place}: the type of {topic} {error}; record it with ros2msg definitions") from None
    names = {field.name for field in types[root]}
    if "header" not in names or not names & set(SIGNALS):
        raise InputError(f"{place}: {topic} has no header or no signal; its {STATE_TYPE} is not this project's")
    return topic, schema, types


def _blocks(scans: Sequence[McapScan], topic: str, schema: Schema) -> Iterator[tuple[McapScan, Block]]:
    """The messages of a topic with that definition, file by file."""
    for scan in scans:
        channels = {
            number
            for number, (name, other) in _state_channels(scan).items()
            if name == topic and other.data == schema.data
        }
        for block in scan.blocks(channels):
            try:
                yield scan, unpacked(block)
            except CdrError as error:
                raise InputError(f"{scan.path}: a message {error}; record it again") from None


def _read(
    scans: Sequence[McapScan], topic: str, schema: Schema, types: Types, progress: Callable[[float], None]
) -> dict[str, np.ndarray]:
    """All samples of a topic, one column per field, `stamp` and `log_time` in ns; signals never known are absent.

    The angle origins are those of the first message: a run has only one.
    """
    columns = _Columns()
    root = "/".join(STATE_TYPE.split("/")[::2])
    origins: dict[str, np.ndarray] = {}
    total = sum(scan.size for scan in scans)
    for scan, block in _blocks(scans, topic, schema):
        progress(sum(scan.place for scan in scans) / total)
        try:
            fields = decode(types, root, block.data, block.offsets, block.sizes, _NAMES)
            if not columns.size:
                origins = decode(types, root, block.data, block.offsets[:1], block.sizes[:1], ANGLE_ORIGINS)
        except CdrError as error:
            raise InputError(f"{scan.path}: a message {error}; it was not written as its definition says") from None
        if absent := [name for name in _STAMP if name not in fields]:
            raise InputError(f"{scan.path}: a message has no {absent[0]}; record it with a std_msgs/Header")
        seconds, nanoseconds = (fields.pop(name).astype(np.int64) for name in _STAMP)
        columns.add({**fields, "stamp": seconds * 1_000_000_000 + nanoseconds, "log_time": block.log_times})
    return {**columns.finish(), **origins}


class _Columns:
    """Columns that grow block by block, so that a long recording is never held twice."""

    def __init__(self) -> None:
        self.size = 0
        self._columns: dict[str, Column] = {}

    def add(self, block: dict[str, np.ndarray]) -> None:
        """Append rows. A signal takes no space before its first known value: most are never known."""
        for name, values in block.items():
            if name not in self._columns:
                if name in SIGNALS and np.isnan(values).all():
                    continue
                self._columns[name] = Column(values.dtype)
                self._columns[name].add_same(_unknown(name), self.size)
            self._columns[name].add(values)
        self.size += len(block["stamp"])
        for name, column in self._columns.items():
            if column.size < self.size:  # a field that this block's messages do not have
                column.add_same(_unknown(name), self.size - column.size)

    def finish(self) -> dict[str, np.ndarray]:
        """The columns, all padded to the same length."""
        return {name: column.finish() for name, column in self._columns.items()}


def _unknown(name: str) -> float:
    """Fill value of a column for unknown entries."""
    return np.nan if name in SIGNALS else 0


class _Samples:
    """Conversion of the samples of one topic to a recording."""

    def __init__(self, file: Path, name: str, topic: str, columns: dict[str, np.ndarray]) -> None:
        self.file, self.name, self.topic, self.columns = file, name, topic, columns
        self.warnings: list[str] = []
        self.origins = {name: float(columns.pop(name)[0]) for name in ANGLE_ORIGINS if name in columns}
        log_times = self.columns.pop("log_time")
        if any((part[1:] < part[:-1]).any() for part in overlapping(log_times)):
            self._keep(np.argsort(log_times, kind="stable"))

    def first_run(self) -> None:
        """Keep the first run: runs are distinguished by their number, otherwise by a stamp that goes back."""
        if "run" in self.columns:
            runs = self.columns["run"]
            later = (runs[rows][runs[rows] != runs[0]] for rows in pieces(len(runs)))
            others = {int(run) for part in later for run in np.unique(part)}
            if not others:
                return
            count = 1 + len(others)
            self._keep(np.flatnonzero(by_pieces(lambda part: part == runs[0], runs)))
        else:
            back = steps_where(lambda steps: steps < 0, self.columns["stamp"])
            if not back.size:
                return
            count = back.size + 1
            self._keep(np.arange(back[0] + 1))
        self._warn(f"holds {count} runs; the first one is used ({len(self.columns['stamp'])} samples)")

    def in_order(self) -> None:
        """Sort, drop repeated samples, and count missing ones."""
        key = self.columns.get("sequence", self.columns["stamp"])
        if any((part[1:] <= part[:-1]).any() for part in overlapping(key)):
            _, first = np.unique(key, return_index=True)
            repeated = len(key) - len(first)
            self._keep(first)
            if repeated:
                self._warn(f"{repeated} samples are there twice; used once")
        stamps = self.columns["stamp"]
        wrong = steps_where(lambda steps: steps <= 0, stamps)
        if wrong.size:
            raise self._error(f"time does not go on at sample {wrong[0] + 1}", "record it again, one run at a time")
        if "sequence" in self.columns:
            sequence = self.columns["sequence"]
            late, missing = int(sequence[0]), int(sequence[-1]) - int(sequence[0]) + 1 - len(sequence)
            if late:
                self._warn(f"begins with sample {late} of its run: the recorder came late")
            if missing:
                self._warn(f"{missing} samples are missing")

    def recording(self, metadata: dict[str, str], warnings: list[str]) -> Recording:
        """The recording, with these warnings and the ones found here."""
        stamps = self.columns["stamp"]
        signals = {}
        for name in SIGNALS:
            if name in self.columns and self._is_known(name, stamps):
                signals[name] = self.columns[name]
        if not signals:
            raise self._error("all signals are NaN", "record a topic that carries values")
        warnings = list(dict.fromkeys([*warnings, *self.warnings]))
        return Recording(
            self.name,
            shifted(stamps, -stamps[0]),
            signals,
            int(stamps[0]),
            **self.origins,
            metadata=metadata,
            warnings=tuple(warnings),
        )

    def _is_known(self, name: str, stamps: np.ndarray) -> bool:
        """True if a signal is known throughout, False if never; an error if it is unknown in places."""
        values = self.columns[name]
        known = sum(np.count_nonzero(np.isfinite(values[rows])) for rows in pieces(len(values)))
        if known in (0, len(values)):
            return bool(known)
        first = int(np.argmin(by_pieces(np.isfinite, values)))
        what = f"{name} is not a number in {len(values) - known} of {len(values)} samples"
        where = f"first {(stamps[first] - stamps[0]) * 1e-9:g} s after the start"
        if name == "unexplained_torque":
            self._warn(f"{what}, {where}; left out")
            return False
        raise self._error(f"{what}, {where}", "record it again, or leave this signal unset throughout")

    def _keep(self, places: np.ndarray) -> None:
        for name in self.columns:
            self.columns[name] = by_pieces(partial(values_at, self.columns[name]), places)

    def _warn(self, message: str) -> None:
        self.warnings.append(f"{self.file.name}: {self.topic}: {message}")

    def _error(self, wrong: str, remedy: str) -> InputError:
        return InputError(f"{self.file}: {self.topic}: {wrong}; {remedy}")
