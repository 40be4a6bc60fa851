"""Times of day and dates in exported files, converted to s so that they become a column of numbers."""

from __future__ import annotations

import re
from datetime import date

_FORM = re.compile(
    r"(?:(?P<year>\d{4})[-/.](?P<month>\d\d?)[-/.](?P<day>\d\d?)[T ]+"
    r"|(?P<day_first>\d\d?)\.(?P<month_second>\d\d?)\.(?P<year_last>\d{4})[T ]+)?"
    r"(?P<hour>\d\d?):(?P<minute>\d\d):(?P<second>\d\d(?:[.,]\d+)?)\s*(?:Z|UTC|[-+]\d\d:?\d\d)?"
)
DAY = 86400.0  # s


def is_time_of_day(text: str) -> bool:
    """Whether a text is a time of day, with or without a date."""
    return _FORM.fullmatch(text) is not None


def seconds(text: str) -> float:
    """The time [s] given by a text: since 1970 if it has a date, otherwise since midnight. Raises ValueError."""
    found = _FORM.fullmatch(text)
    if found is None:
        raise ValueError(f"{text!r} is no time of day")
    of_day = 3600.0 * int(found["hour"]) + 60.0 * int(found["minute"]) + float(found["second"].replace(",", "."))
    year = found["year"] or found["year_last"]
    if year is None:
        return of_day
    month, day = found["month"] or found["month_second"], found["day"] or found["day_first"]
    return DAY * (date(int(year), int(month), int(day)) - date(1970, 1, 1)).days + of_day
