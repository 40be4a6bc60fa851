"""Dates of recordings: in their names, and without a time of day."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime, time, timezone
from typing import Any

_DATE = re.compile(r"(?<!\d)(\d{4})([-_.]?)(\d\d)\2(\d\d)(?!\d)", re.ASCII)


def dated(row: Mapping[str, Any]) -> Mapping[str, Any]:
    """A row of the store, with the date in its name if it has no time; its health then belongs to that day's test."""
    if row["time"] is not None or (date := _date_in(row["name"].replace(row["unit"], " ", 1))) is None:
        return row
    health = row["health"]
    if health is not None and health["test"] == row["name"]:  # nothing better was known
        health = {**health, "test": f"{date:%Y-%m-%d}"}
    return {**row, "time": date, "health": health}


def has_time_of_day(at: datetime) -> bool:
    """Whether a time is more than a date: no recording begins at midnight to the microsecond."""
    return at.time() != time.min


def when_words(at: datetime | None) -> str:
    """When something was recorded: ``2026-03-31 14:05``, or as much as is known of it."""
    if at is None:
        return ""
    return f"{at:%Y-%m-%d %H:%M}" if has_time_of_day(at) else f"{at:%Y-%m-%d}"


def _date_in(name: str) -> datetime | None:
    """The last date in a name (2026-03-31, 2026_03_31 or 20260331); None if it holds none."""
    for found in reversed([*_DATE.finditer(name)]):
        try:
            return datetime(int(found[1]), int(found[3]), int(found[4]), tzinfo=timezone.utc)
        except ValueError:  # digits that are no date, such as a serial number
            continue
    return None
