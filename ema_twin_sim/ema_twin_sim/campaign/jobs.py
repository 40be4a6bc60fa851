"""Jobs: which recordings of a folder belong to which unit, and which are judged together."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple

from ema_bench_replay.bags.bag_parts import recordings_in
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import TRACES

from ..model.model_file import model_files
from ..text_traces import without_notes

HEALTH = "health"
"""Verb that computes features of each recording, by which a unit is judged against its healthy ones; needs no model."""
SEARCHING = ("diagnose", "discover")
"""Verbs that look for what a model lacks."""
VERBS = ("compare", "fit", *SEARCHING, HEALTH)
APART = "recording"
TOGETHER = (APART, "folder", "unit")
GROUPS = {"unit", "time", "test"}
"""The groups that a pattern of names may have."""
_KEY_BYTES = 16


@dataclass(frozen=True)
class Task:
    """What is done with every job: a verb with a model."""

    verb: str  # one of VERBS
    model: str  # a file, or a name in config/models; may be empty for health
    import_map: str = "siemens"
    without: tuple[str, ...] = ()
    wavelength: float | None = None  # m or rad, of what repeats with the position; None: from the model

    def identity(self) -> str:
        """Text that identifies this task; a model counts by its content, not by its path."""
        files = model_files(self.model) if self.model else ()
        content = [hashlib.blake2b(file.read_bytes()).hexdigest() for file in files]
        return json.dumps([self.verb, content, self.import_map, sorted(self.without), self.wavelength])


@dataclass(frozen=True)
class Job:
    """Recordings of one unit that are judged together."""

    key: str  # the same for the same unchanged recordings and the same task
    unit: str
    name: str  # of the recording, of its folder, or of the unit
    recordings: tuple[tuple[str, ...], ...]  # the path of each, or the files of one that a recorder has split
    time: datetime | None = None  # from the path, of the last recording; None if only the recording may have it
    test: str | None = None  # from the path, likewise: what was set up once
    apart: bool = True  # whether each run of a file that holds many has a result of its own


class Place(NamedTuple):
    """Where a recording belongs, as far as its path says."""

    unit: str
    time: datetime | None
    test: str | None


@dataclass(frozen=True)
class Grouping:
    """How a folder's recordings are grouped: by a pattern of their paths, and by what is judged together.

    Without a ``pattern``, a unit is a folder in ``folder``, or ``folder`` itself, and a test is a folder in a unit. A
    pattern is searched for in each path relative to ``folder``; its groups ``unit`` and, if it has them, ``time``
    (ISO 8601) and ``test`` are used.
    """

    folder: Path
    pattern: re.Pattern[str] | None = None
    together: str = "recording"

    @classmethod
    def of(cls, folder: Path, pattern: str | None, together: str) -> Grouping:
        """Make a grouping. Raises InputError if the folder is none, or the pattern is invalid or has no unit."""
        if not folder.is_dir():
            raise InputError(f"{folder}: is no folder; give the folder that holds the recordings")
        if together not in TOGETHER:
            raise InputError(f"--together {together}: is not known; give {', '.join(TOGETHER[:-1])} or {TOGETHER[-1]}")
        if pattern is None:
            return cls(folder, None, together)
        try:
            compiled = re.compile(pattern)
        except re.error as error:
            raise InputError(f"--unit {pattern}: is no regular expression ({error})") from None
        if "unit" not in compiled.groupindex or not {*compiled.groupindex} <= GROUPS:
            raise InputError(
                f"--unit {pattern}: its groups are wrong; give (?P<unit>...) and, if useful, (?P<time>...) or "
                "(?P<test>...)"
            )
        return cls(folder, compiled, together)

    def place(self, file: Path) -> Place | None:
        """Where a recording belongs; None if the pattern does not match its path."""
        path = file.relative_to(self.folder)
        if self.pattern is None:
            if len(path.parts) == 1:
                return Place(self.folder.resolve().name, None, None)
            unit, *between, _ = path.parts
            return Place(unit, None, "/".join(between) or None)
        found = self.pattern.search(path.as_posix())
        if found is None or not found["unit"]:
            return None
        test = (found["test"] or None) if "test" in self.pattern.groupindex else None
        if "time" not in self.pattern.groupindex or not found["time"]:
            return Place(found["unit"], None, test)
        try:
            when = datetime.fromisoformat(found["time"])
        except ValueError:
            raise InputError(f"{file}: {found['time']} is not an ISO 8601 time; write it like 2026-03-31") from None
        return Place(found["unit"], when if when.tzinfo else when.replace(tzinfo=timezone.utc), test)

    def group(self, file: Path, unit: str) -> str:
        """Name of the group of recordings that this one is judged with."""
        path = file.relative_to(self.folder)
        if self.together == "unit":
            return unit
        return (path if self.together == "recording" else path.parent).as_posix()


def find_recordings(folder: Path, skipped: Sequence[Path] = ()) -> Iterator[tuple[Path, ...]]:
    """Yield the recordings below a folder in the order of their names: text traces, .mcap files, bags, and the files of
    a recording that a recorder has split.

    Hidden files and folders, and those ``skipped``, are left out; links to folders are followed.
    """
    left_out = {path.resolve() for path in skipped}
    for place, folders, files in os.walk(folder, followlinks=True):
        here = Path(place)
        around = {here.resolve(), *here.resolve().parents}  # a link back to one of these would never end
        folders[:] = sorted(
            f for f in folders if not f.startswith(".") and (here / f).resolve() not in left_out | around
        )
        if "metadata.yaml" in files and any(file.endswith(".mcap") for file in files):
            folders.clear()
            yield (here,)
            continue
        shown = [here / file for file in sorted(files) if not file.startswith(".")]
        bags = recordings_in([file for file in shown if file.suffix == ".mcap"])
        yield from sorted([*bags, *((file,) for file in shown if file.suffix.lower() in TRACES)])


def _found(folder: Path, skipped: Sequence[Path], tell: Callable[[str], None]) -> list[tuple[Path, ...]]:
    """The recordings of a folder; the text files of other names than .csv only if it holds nothing else.

    Raises InputError if it holds none.
    """
    found = without_notes(folder, [*find_recordings(folder, skipped)], tell)
    if not found:
        raise InputError(f"{folder}: holds no recording; give a folder with CSVs or .mcap files in it")
    return found


def find_jobs(
    grouping: Grouping, task: Task, skipped: Sequence[Path] = (), tell: Callable[[str], None] = lambda text: None
) -> list[Job]:
    """The jobs of a folder; recordings without a unit, or with an invalid time, are left out and passed to ``tell``.

    Raises InputError if there is no recording, none that matches, or none with a valid time.
    """
    of: dict[tuple[str, str], list[tuple[tuple[Path, ...], Place]]] = {}
    strays: list[Path] = []
    no_times: list[InputError] = []
    found = _found(grouping.folder, skipped, tell)
    count = len(found)
    for parts in found:
        try:
            place = grouping.place(parts[0])
        except InputError as error:  # one wrong name must not stop the campaign
            no_times.append(error)
            continue
        if place is None:
            strays.append(parts[0])
            continue
        of.setdefault((place.unit, grouping.group(parts[0], place.unit)), []).append((parts, place))
    if len(strays) == count:
        raise InputError(
            f"none of {count} recordings in {grouping.folder} matches --unit; the first is {strays[0].name}; correct "
            "the pattern, which is searched for in each recording's path"
        )
    if strays:
        tell(f"{len(strays)} of {count} recordings do not match --unit and are left out; the first is {strays[0]}")
    if no_times:
        tell(f"{no_times[0]}: left out" + (f", as are {len(no_times) - 1} more" if len(no_times) > 1 else ""))
        if not of:
            raise InputError(f"{no_times[0]}; of all {count} recordings none has a time; check the pattern of --unit")
    identity = task.identity()
    return [
        Job(
            _key(identity, grouping.folder, [file for parts, _ in recordings for file in parts]),
            unit,
            name,
            tuple(tuple(map(str, parts)) for parts, _ in recordings),
            max((place.time for _, place in recordings if place.time is not None), default=None),
            recordings[0][1].test,
            grouping.together == APART,
        )
        for (unit, name), recordings in of.items()
    ]


def _key(identity: str, folder: Path, files: Sequence[Path]) -> str:
    """Key of a job: a recording whose size or time of modification has changed makes another job."""
    parts = [identity]
    for file in sorted(files):
        held = sorted(file.iterdir()) if file.is_dir() else [file]
        for one in held:
            about = one.stat()
            parts.append(f"{one.relative_to(folder).as_posix()} {about.st_size} {about.st_mtime_ns}")
    return hashlib.blake2b("\n".join(parts).encode(), digest_size=_KEY_BYTES).hexdigest()
