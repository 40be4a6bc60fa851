"""Columns that hold what another one holds, at once or some samples later: copies, and no measurements of their own.

Logs of controllers hold them: the last position, the action before. A second encoder shows play or noise of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.traces.header_words import HeaderWords
from ema_bench_replay.units import MOTIONS, units_of

from ..criteria import FEWEST_ROWS, MOSTLY, NEARLY_ALL, NEGLIGIBLE
from ..listing import number_of
from .column_quantity import has_word
from .column_words import COMPUTED, FILTERED
from .signal_columns import Column, signal_column

_SIGNALS = {"position": "motor_position", "speed": "speed", "current": "current", "torque": "motor_torque"}
_LATEST = 10  # samples that a copy may be late
_MOST_DECIMALS = 16  # of a number in a text
_LOOKED_AT = 1000  # rows that rule out most pairs


def repeated_columns(names: Sequence[HeaderWords], numbers: Mapping[str, np.ndarray]) -> dict[str, str]:
    """By the name of each column that is a copy, what it repeats, in words. ``numbers`` (n,) are each column's.

    Only columns of the same quantity are compared, and commands with commands. Of those that are equal at once, the one
    whose name tells less is the copy, or else the later one.
    """
    columns = [column for column in map(signal_column, reversed(names)) if column and column.name in numbers]
    columns = sorted((column for column in columns if column.quantity in _SIGNALS), key=_tells_little, reverse=True)
    sizes = {column.name: (numbers[column.name], _last_digit(numbers[column.name])) for column in columns}
    found: dict[str, tuple[Column, int]] = {}
    zeroed: dict[str, str] = {}
    for place, copy in enumerate(columns):
        beside = [
            (other, later)
            for k, other in enumerate(columns)
            if k != place and _is_alike(other, copy) and _first_of_all(other, found)[0] is not copy
            for later in [_samples_later(sizes[copy.name], sizes[other.name], _factor(copy, other), at_once=k > place)]
            if later is not None
        ]
        if beside:
            found[copy.name] = max(beside, key=lambda each: each[1])
            continue
        for other in columns[place + 1 :]:
            # of a measured position a program may have set zero and direction anew
            if copy.quantity != "position" or copy.setpoint or not _is_alike(other, copy):
                continue
            if how := _from_another_zero(sizes[copy.name], sizes[other.name], _factor(copy, other)):
                zeroed[copy.name] = f"holds the values of {other.name}, {how}: it is no second encoder"
                break
    copies = [column for column in columns if column.name in found]
    return {copy.name: _in_words(copy, *_first_of_all(copy, found)) for copy in copies} | zeroed


def _from_another_zero(copy: tuple[np.ndarray, float], original: tuple[np.ndarray, float], factor: float) -> str:
    """How a copy (n,) counts an original (n,) anew: from another zero, or also the other way; empty if it does not.

    Each comes with the size of its last digit.
    """
    values = copy[0] * factor
    digit = copy[1] * factor + original[1]  # the zero is known no better than two rounded values tell it
    for sign, way in ((1.0, ""), (-1.0, " and the other way round")):
        zero = float(np.median(values - sign * original[0]))
        if np.isfinite(zero) and _are_equal(values - zero, sign * original[0], digit):
            return f"counted from another zero{way}"
    return ""


def _first_of_all(column: Column, found: Mapping[str, tuple[Column, int]]) -> tuple[Column, int]:
    """The column that this one repeats in the end, itself if it is no copy, and how many samples later."""
    later = 0
    while column.name in found:
        column, more = found[column.name]
        later += more
    return column, later


def _tells_little(column: Column) -> tuple[bool, ...]:
    """How little a column's name tells: of two with the same values, the one with the larger key is the copy."""
    return (
        has_word(column.read.words, f"{FILTERED}|{COMPUTED}"),
        column.shaft == "",
        column.shaft == "output",
        column.read.unit is None,
        not column.actual,
    )


def _is_alike(one: Column, other: Column) -> bool:
    return (one.quantity, one.setpoint) == (other.quantity, other.setpoint)


def _factor(copy: Column, original: Column) -> float:
    """How many units of the original one of the copy's is; 1 if a name does not tell its unit."""
    known = {unit: size for motion in MOTIONS for unit, size in units_of(_SIGNALS[copy.quantity], motion).items()}
    of_copy, of_original = (known.get(column.read.unit or "") for column in (copy, original))
    return 1.0 if of_copy is None or of_original is None else of_copy / of_original


def _samples_later(
    copy: tuple[np.ndarray, float], original: tuple[np.ndarray, float], factor: float, *, at_once: bool
) -> int | None:
    """After how many samples a copy (n,) repeats an original (n,); None if it does not.

    Each comes with the size of its last digit. ``at_once``: whether equal values in the same rows count.
    """
    values = copy[0] * factor
    digit = max(copy[1] * factor, original[1])
    for later in range(0 if at_once else 1, min(_LATEST + 1, len(values))):
        if _are_equal(values[later:], original[0][: len(values) - later], digit):
            return later
    return None


def _are_equal(one: np.ndarray, other: np.ndarray, digit: float) -> bool:
    """Whether two columns (n,) are equal to the last ``digit`` in nearly all rows, and wherever one of them changes."""
    close = NEGLIGIBLE**4 * max(float(np.abs(other).max()), np.finfo(float).tiny)
    few = slice(None, None, max(1, len(one) // _LOOKED_AT))
    if np.mean(np.abs(one[few] - other[few]) <= 0.5 * digit + close) < MOSTLY:
        return False
    equal = np.abs(one - other) <= 0.5 * digit + close
    changes = _changes(one, digit) | _changes(other, digit)
    if np.count_nonzero(changes) < FEWEST_ROWS:
        return False
    return bool(min(equal.mean(), equal[1:][changes].mean()) >= NEARLY_ALL)


def _changes(values: np.ndarray, digit: float) -> np.ndarray:
    """Which values but the first differ from the one before, to the last ``digit`` (n - 1,)."""
    return np.diff(np.rint(values / digit) if digit else values) != 0.0


def _last_digit(values: np.ndarray) -> float:
    """The size of the last decimal of values (n,); 0 if they have more than a text holds."""
    decimals = (places for places in range(_MOST_DECIMALS) if np.array_equal(np.round(values, places), values))
    return next((10.0**-places for places in decimals), 0.0)


def _in_words(copy: Column, original: Column, later: int) -> str:
    """What a column does that is a copy."""
    end = ": it is no second encoder" if copy.quantity == "position" and not copy.setpoint else ""
    if not later:
        return f"holds the same values as {original.name}{end}"
    return f"repeats {original.name} {'one sample' if later == 1 else number_of(later, 'sample')} later{end}"
