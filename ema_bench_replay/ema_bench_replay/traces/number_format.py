"""Number format of a text file: `1.445.660,5` (German) or `1,445,660.5` (English), decided from the whole file."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

# Bytes examined first; more are read only while the format is undecided.
_SAMPLE = 4096

_DIGITS = np.zeros(256, dtype=bool)
_DIGITS[ord("0") : ord("9") + 1] = True


@dataclass(frozen=True)
class NumberFormat:
    """A decimal mark and the thousands mark that goes with it."""

    name: str  # "German" or "English"
    decimal: str
    thousands: str

    @property
    def example(self) -> str:
        """The format in words."""
        return f"{self.name} ({f'{1234.5:,.1f}'.translate(str.maketrans(',.', self.thousands + self.decimal))})"

    @cached_property
    def pattern(self) -> re.Pattern[str]:
        """Pattern of a whole number text in this format; thousands in groups of three or not grouped."""
        decimal, thousands = re.escape(self.decimal), re.escape(self.thousands)
        whole = rf"(?:[1-9]\d{{0,2}}(?:{thousands}\d{{3}})+|\d+)"
        return re.compile(rf"[+-]?(?:{whole}(?:{decimal}\d*)?|{decimal}\d+)(?:[eE][+-]?\d+)?", re.ASCII)

    def value(self, text: str) -> float:
        """The number written in `text`; ValueError if it is not in this format."""
        if not self.pattern.fullmatch(text):
            raise ValueError(text)
        return float(text.replace(self.thousands, "").replace(self.decimal, "."))

    def groups_are_whole(self, text: bytes) -> bool:
        """Whether every thousands mark in `text` follows one to three digits and precedes exactly three."""
        mark = ord(self.thousands)
        padded = np.frombuffer(b"\n\n\n\n" + text + b"\n\n\n\n", dtype=np.uint8)
        marks = np.flatnonzero(padded == mark)
        if not marks.size:
            return True
        digit = [_DIGITS[padded[marks + k]] for k in range(-4, 5)]  # digit[4 + k]: the character k after the mark
        if not (digit[3] & digit[5] & digit[6] & digit[7] & ~digit[8]).all():
            return False
        lead = np.where(digit[2], np.where(digit[1], 3, 2), 1)  # digits before the mark, up to three
        before = padded[marks - lead - 1]
        first = padded[marks - lead]
        continued = (before == mark) & (lead == 3)
        leading = ~_DIGITS[before] & (before != mark) & (before != ord(self.decimal)) & (first != ord("0"))
        return bool((continued | leading).all())


GERMAN = NumberFormat("German", ",", ".")
ENGLISH = NumberFormat("English", ".", ",")
FORMATS = {"german": GERMAN, "english": ENGLISH}


def detect(text: bytes, delimiter: str, likely: NumberFormat) -> tuple[NumberFormat, str | None]:
    """The format of the numbers in `text` (rows of cells), and the assumption made if the text leaves it open.

    A mark decides if it has only one meaning: both marks in one number, one mark twice, or a group that does not have
    three digits. If numbers disagree, the majority decides, and reading reports the others. `812.347` alone decides
    nothing; then the time column decides (it may not go backwards), otherwise `likely` is assumed.
    """
    size = _SAMPLE
    while True:
        votes, unsettled = _evidence(text[:size], delimiter)
        if votes:
            return (GERMAN if votes[","] >= votes["."] else ENGLISH), None
        if size >= len(text):
            break
        size *= 16
    if not unsettled:
        return likely, None
    times = [line.split(delimiter)[0].strip() for line in text.decode("latin-1").split("\n") if line.strip()]
    rising = [form for form in (GERMAN, ENGLISH) if form.thousands != delimiter and _rises(times, form)]
    if len(rising) == 1:
        return rising[0], None
    kind = "thousands" if likely.thousands in unsettled else "decimals"
    return likely, f"numbers such as {unsettled} may show thousands or decimals; taken for {likely.name} {kind}"


def _evidence(sample: bytes, delimiter: str) -> tuple[Counter[str], str]:
    """How many different numbers indicate each decimal mark, and an example of those that leave it open.

    Only a cell that is a number as a whole counts: the commas of a list in a cell are no decimal marks.
    """
    marks = "." if delimiter == "," else ".,"
    votes: Counter[str] = Counter()
    unsettled = ""
    rows = sample[: sample.rfind(b"\n") + 1] or sample
    begins, ends = rf"(?<![^\n{re.escape(delimiter)}])", rf"(?![^\n{re.escape(delimiter)}])"
    cell = rf"{begins}([-+]?[0-9{marks}]*[{marks}][0-9{marks}]*)(?:[eE][-+]?[0-9]+)?{ends}"
    for number in dict.fromkeys(re.findall(cell, rows.decode("latin-1"))):
        if mark := _decimal_mark(number):
            votes[mark] += 1
        else:
            unsettled = unsettled or number
    return votes, unsettled


def _decimal_mark(number: str) -> str | None:
    """The decimal mark of this number; None if it may be either."""
    dots, commas = number.count("."), number.count(",")
    if dots and commas:
        return "," if number.rindex(",") > number.rindex(".") else "."
    mark = "." if dots else ","
    if dots + commas > 1:
        return "," if mark == "." else "."
    head, tail = number.lstrip("+-").split(mark)
    if len(tail) != 3 or not 1 <= len(head) <= 3 or head.startswith("0"):
        return mark
    return None


def _rises(cells: list[str], form: NumberFormat) -> bool:
    try:
        values = [form.value(cell) for cell in cells]
    except ValueError:
        return False
    return all(low < high for low, high in pairwise(values))
