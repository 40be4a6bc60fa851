"""Units: the results of a campaign for each unit, and which of them must not be compared with each other."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby, pairwise
from typing import Any

from ..listing import listed
from .dates import dated, has_time_of_day
from .results import DONE, FAILED, LEFT_OUT, REFUSED

Row = Mapping[str, Any]
_NUMBER = re.compile(r"(\d+)", re.ASCII)


@dataclass(frozen=True)
class Unit:
    """One unit: its ``rows``, in the order of recording as far as it is known."""

    name: str
    rows: tuple[Row, ...]
    remarks: tuple[str, ...]  # why some rows do not belong together

    @property
    def judged(self) -> int:
        """Number of results."""
        return self._count(DONE)

    @property
    def refused(self) -> int:
        """Number of inputs that could not be judged."""
        return self._count(REFUSED)

    @property
    def failed(self) -> int:
        """Number of inputs lost to an error."""
        return self._count(FAILED)

    @property
    def left_out(self) -> int:
        """Number of recordings that could not be read, where those judged together with them could."""
        return len(_left_out(self.rows))

    @property
    def last(self) -> datetime | None:
        """Time of the last recording."""
        return max((row["time"] for row in self.rows if row["time"] is not None), default=None)

    @property
    def searched(self) -> int:
        """Number of results in which effects were looked for."""
        return sum(row["verdict"] is not None for row in self.rows)

    @property
    def missing(self) -> list[tuple[str, int]]:
        """(effect, in how many results the model lacks it), the most frequent first; ``unknown`` is one of them."""
        found = Counter(effect for row in self.rows for effect in row["missing"] or ())
        found.update("unknown" for row in self.rows if row["verdict"] == "unknown")
        return sorted(found.items(), key=lambda item: (-item[1], item[0]))

    @property
    def beyond_noise(self) -> float | None:
        """The largest error of a signal in the last result, in times the sensors' noise; None if there is none."""
        return next((b for row in reversed(self.rows) if (b := self.beyond(row)) is not None), None)

    @staticmethod
    def beyond(row: Row) -> float | None:
        """The same for one result; 1 if no error exceeds the noise."""
        if row["errors"] is None:
            return None
        return max((signal["times"] for signal in row["beyond_noise"] or ()), default=1.0)

    def as_json(self) -> dict[str, object]:
        """Times in ISO 8601; absent numbers are null."""
        return {
            "unit": self.name,
            "judged": self.judged,
            "refused": self.refused,
            "failed": self.failed,
            "left_out": self.left_out,
            "last": None if self.last is None else self.last.isoformat(),
            "searched": self.searched,
            "missing": [{"effect": effect, "results": count} for effect, count in self.missing],
            "beyond_noise": self.beyond_noise,
            "remarks": list(self.remarks),
        }

    def _count(self, status: str) -> int:
        return sum(row["status"] == status for row in self.rows)


def units_of(rows: Iterable[Row]) -> list[Unit]:
    """The units of rows that are sorted by unit; the unit with the largest error in times its noise first.

    A row without a time has the date that its name holds.
    """
    units = []
    for name, its in groupby(rows, key=lambda row: row["unit"]):
        of = tuple(sorted(map(dated, its), key=_when))
        units.append(Unit(name, of, tuple(_remarks(of))))
    return sorted(units, key=lambda unit: (-(unit.beyond_noise or 0.0), unit.name))


def _when(row: Row) -> tuple[bool, float, list[tuple[int, str]]]:
    """Sort key of a row: its time, else its name, with numbers in it compared as numbers."""
    time = row["time"]
    pieces = _NUMBER.split(row["name"])
    name = [(int(piece), "") if k % 2 else (-1, piece) for k, piece in enumerate(pieces)]
    return time is None, 0.0 if time is None else time.timestamp(), name


def _left_out(rows: Iterable[Row]) -> list[str]:
    """The warnings of recordings that could not be read, each once."""
    return list(dict.fromkeys(told for row in rows for told in row.get("warnings") or () if told.endswith(LEFT_OUT)))


def _remarks(rows: Sequence[Row]) -> Iterable[str]:
    """Yield which of a unit's results do not belong together, and why.

    Reasons: recordings that could not be read, other kinds of machine or signals, copies, clocks that disagree, missing
    dates, a single recording.
    """
    yield from _left_out(rows)
    done = [row for row in rows if row["status"] == DONE]
    motions = sorted({row["motion"] for row in done if row["motion"]})
    if len(motions) > 1:
        yield f"has recordings of {listed(motions)} machines: separate the units with --unit"
    signals = {tuple(row["signals"] or ()) for row in done}
    if len(signals) > 1:
        most = max(signals, key=lambda held: sum(tuple(row["signals"] or ()) == held for row in done))
        odd = next(row for row in done if tuple(row["signals"] or ()) != most)
        apart = sorted({*most} ^ {*(odd["signals"] or ())})
        yield f"{odd['name']} and others have different signals ({listed(apart)}), so their errors cannot be compared"
    first_of: dict[str, str] = {}
    for row in done:
        for content in row["content"] or ():
            first = first_of.setdefault(content, row["name"])
            if first != row["name"]:
                yield f"{row['name']} is a copy of {first}: it counts twice; remove one"
    timed = [row for row in done if row["time"] is not None]
    clocked = sorted((row for row in timed if has_time_of_day(row["time"])), key=lambda row: row["time"])
    for before, after in pairwise(clocked):
        overlap = before["duration"] - (after["time"] - before["time"]).total_seconds()
        single = len(before["content"] or ()) == len(after["content"] or ()) == 1  # of several, the last one's time
        if overlap > 0.0 and single and before["task"] == after["task"] and before["content"] != after["content"]:
            yield f"{after['name']} begins before {before['name']} ends: one of their clocks is wrong"
            break
    if timed and len(timed) < len(done):
        yield f"{len(done) - len(timed)} of {len(done)} results have no date; they are sorted by name"
    if len({content for row in done for content in row["content"] or ()}) == 1:
        yield "has only one recording, so changes cannot be detected"
