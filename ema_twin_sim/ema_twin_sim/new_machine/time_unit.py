"""The unit of a clock that names none: by the motion it times, by its size if it counts from 1970, else by its steps.

A speed beside a position decides, since the one times the time is the other's way. A time that counts from 1970 has a
size that only one unit gives. What remains are steps. A counter has whole numbers, and is taken in the largest unit in
which the samples come as fast as a drive's. Fractions are written by those who count seconds, up to steps of nearly
one: those may be a drive's millisecond.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ema_bench_replay.traces.import_map import TIME_UNITS
from ema_bench_replay.traces.time_of_day import seconds

from ..criteria import MOSTLY
from ..model.constants import CONSTANTS

SLOWEST_SAMPLES = 0.1
"""s, longest sample period of a drive's trace; a counter without a unit that is slower is taken in a smaller unit."""

_SINCE_1970 = seconds("2000-01-01 00:00:00"), seconds("2100-01-01 00:00:00")
"""s, between which a time that counts from 1970 lies."""


def time_unit(time: np.ndarray, by_motion: str | None = None) -> tuple[str, str]:
    """The unit of a ``time`` (n,), and what to check about it; ``by_motion`` is the one that its motion tells."""
    if by_motion is not None:
        return by_motion, "" if by_motion == "s" else "no unit in the header; with it, position and speed agree"
    if len(time) < 2:
        return "s", ""  # which is refused as a recording, with its own words
    step = float(np.median(np.diff(time)))
    longest = CONSTANTS["sensors.sample_period"].upper
    for unit, size in TIME_UNITS.items():
        began, period = float(time[0]) * size * 1e-9, step * size * 1e-9
        # a counter of a smaller unit that happens to be as large makes far longer steps
        if _SINCE_1970[0] < began < _SINCE_1970[1] and period < longest:
            return unit, "" if unit == "s" else "no unit in the header; with it, it counts from 1970"
    if step <= SLOWEST_SAMPLES:
        return "s", ""
    if step < MOSTLY * longest and np.any(time != np.rint(time)):
        return "s", "no unit in the header; in s because of its fractions, though the samples come slowly then"
    fast_enough = (unit for unit, size in TIME_UNITS.items() if step * size * 1e-9 <= SLOWEST_SAMPLES)
    return next(fast_enough, "ns"), "no unit in the header; otherwise the sample period would be too long"


def smaller_unit(unit: str) -> str | None:
    """The unit of time that is a thousandth of a ``unit``; None if there is none."""
    return next((other for other, size in TIME_UNITS.items() if 1000 * size == TIME_UNITS[unit]), None)


def unit_of_size(sizes: Sequence[float], tolerance: float) -> str | None:
    """The unit of time that has one of these ``sizes`` [s], nearly; None if none has, or several do."""
    found = {
        size: unit
        for unit, size in reversed(TIME_UNITS.items())
        if any(abs(each / (size * 1e-9) - 1.0) < tolerance for each in sizes)
    }
    return next(iter(found.values())) if len(found) == 1 else None
