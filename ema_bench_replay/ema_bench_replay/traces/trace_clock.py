"""A trace's clock: the stamps of its rows, which rows it leaves out, and what it refuses."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.errors import InputError, TimeGoesBackError
from ema_bench_replay.long_columns import by_pieces, differences, extremes, less_rows, median, overlapping, steps_where
from ema_bench_replay.some_of import some_of
from ema_bench_replay.traces.import_map import TIME_UNITS, Column, ImportMap
from ema_bench_replay.traces.run_columns import how_to_read_runs, run_columns
from ema_bench_replay.traces.stray_rows import stray_rows
from ema_bench_replay.traces.trace_table import TraceTable
from ema_bench_replay.traces.wrapped_time import WrappedTime, unwrapped_time

# A step differs from the usual one if it is off by more than this share and by more than the time column resolves.
_UNEQUAL = 0.01
# Share of rows that may repeat the time of the row before: a clock too coarse for its sampling. More means it is stuck.
_REPEATED = 0.1
# Share of rows at the end that may all tell the same time: a clock that stopped before the log did.
_STOPPED = 0.5


@dataclass(frozen=True)
class Clock:
    """When the rows of a table were recorded.

    Attributes:
        table: the rows that have a time of their own.
        stamps: ns (n,), from 0 on.
        place: index of the time column; None if operating points have none.
        origin: the column's value at the first sample.
        unit: the column's unit, a key of TIME_UNITS.
        findings: what was found and left out, in words.
    """

    table: TraceTable
    stamps: np.ndarray
    place: int | None
    origin: float
    unit: str
    findings: tuple[str, ...] = ()


def read_clock(table: TraceTable, import_map: ImportMap) -> Clock:
    """The clock of a table: its time column, by the map.

    Operating points may have no time column: then they are one second apart. Raises InputError on a clock that goes
    back, stops, or repeats itself too often.
    """
    if import_map.time is None:
        return Clock(table, np.arange(len(table.columns[0]), dtype=np.int64) * int(TIME_UNITS["s"]), None, 0.0, "s")
    place = _time_column(table, import_map.time)
    unit = _unit(table.header[place], import_map.time_unit)
    stamps = _stamps(table.columns[place], unit)
    findings: list[str] = []
    wrapped = unwrapped_time(stamps, unit, float(table.columns[place][0]))
    if wrapped is not None and not import_map.of_points:
        findings.append(_wraps_in_words(table, place, unit, wrapped))
        stamps = wrapped.stamps
    back, repeats = _not_rising(stamps)
    few, stopped = _left_out(repeats, len(stamps))
    if few.size + stopped.size and not back.size:
        findings += _in_words(table, place, unit, few, stopped)
        table = table.without(repeats)
        stamps = less_rows(stamps, repeats)
        back, repeats = _not_rising(stamps)
    if back.size or repeats.size:
        raise _refusal(table, place, unit, stamps, back, repeats, import_map)
    if len(stamps) < 2:
        raise InputError(f"{table.path}: has one row only; a recording needs at least two")
    if not import_map.of_points:
        findings += _steps_in_words(stamps, TIME_UNITS[unit] * 10.0 ** -table.decimals[place])
    return Clock(table, stamps, place, float(table.columns[place][0]), unit, tuple(findings))


def _time_column(table: TraceTable, wanted: Column) -> int:
    places = wanted.find(table.header)
    if not places:
        shown = some_of(table.header)
        raise InputError(
            f"{table.path}: line {table.header_line}: no time column ({wanted.name}) among {shown}; "
            "give the map of this machine with --map (init writes one), or export the trace with its time axis"
        )
    return places[0]


def _unit(name: str, otherwise: str) -> str:
    """The unit in brackets in a column's name, or the map's."""
    in_brackets = re.search(r"[\[(]\s*([^\])]+?)\s*[\])]", name)
    return in_brackets[1] if in_brackets and in_brackets[1] in TIME_UNITS else otherwise


def _wraps_in_words(table: TraceTable, place: int, unit: str, wrapped: WrappedTime) -> str:
    """After what the time begins again, where and how often."""
    often = f"{len(wrapped.falls)} times, first" if len(wrapped.falls) > 1 else "once,"
    return (
        f"column {table.header[place]!r}: time begins again after {wrapped.span / TIME_UNITS[unit]:.10g} {unit}, "
        f"{often} in line {table.line(int(wrapped.falls[0]))}: repaired, counted on (if another run begins there, cut "
        "the file)"
    )


def _in_words(table: TraceTable, place: int, unit: str, few: np.ndarray, stopped: np.ndarray) -> list[str]:
    """What is left out: the ``stopped`` rows at the end, and a ``few`` others that repeat the time before."""
    words = []
    if stopped.size:
        last = stopped[0] - 1
        words.append(
            f"the clock stops in line {table.line(last)}, at {table.columns[place][last]:.10g} {unit}: the "
            f"{stopped.size} rows below it, which tell the same time, are left out"
        )
    if few.size:
        those, tell = ("rows", "tell") if few.size > 1 else ("row", "tells")
        first = f"{few.size} {those} (the first in line {table.line(few[0])})"
        words.append(f"{first} {tell} the time of the row before: left out")
    return words


def _refusal(
    table: TraceTable,
    place: int,
    unit: str,
    stamps: np.ndarray,
    back: np.ndarray,
    repeats: np.ndarray,
    import_map: ImportMap,
) -> InputError:
    """Why a clock with rows that go ``back`` or with ``repeats`` is none, where, and what to do."""
    values = table.columns[place]
    row = int(back[0] if back.size else repeats[0])
    how, remedy = "goes back", f"cut the file there, it holds more than one run{_reading_runs(table, import_map)}"
    if 1 < back.size == len(values) - 1 - repeats.size:
        how, remedy = "falls", "it does so from row to row throughout: sort the rows by their time, or reverse them"
    elif back.tolist() == [1]:
        remedy = f"only the first row is late: remove line {table.line(0)}"
    elif (stray := stray_rows(stamps, back)).size:
        remedy = _stray_in_words(table, place, unit, stray)
    if not back.size:
        how = "repeats"
        remedy = (
            f"{repeats.size} of {len(values)} rows do: export it with more decimals or, if rows of several parts of "
            "the machine take turns, write those of each into a file of its own"
        )
        if (stopped := _last_run(repeats, len(values))).size >= max(2.0, _STOPPED * len(values)):
            row = int(stopped[0])
            how, remedy = "stops", f"all {stopped.size} rows from here on tell the same: cut them off"
    shown = f"{values[row]:.10g} {unit} after {values[row - 1]:.10g} {unit}"
    said = f"{table.place(row)}: column {table.header[place]!r}: time {how} ({shown}); {remedy}"
    return TimeGoesBackError(said, len(values)) if back.size else InputError(said)


def _stray_in_words(table: TraceTable, place: int, unit: str, stray: np.ndarray) -> str:
    """What to do with rows (m,) that lie out of order by themselves."""
    lines = some_of(str(table.line(int(row))) for row in stray)
    if stray.size > 1:
        return f"{stray.size} single rows lie out of order, and time goes on after each: remove lines {lines}"
    value = f"{table.columns[place][stray[0]]:.10g} {unit}"
    goes_on = ", and time goes on after it" if stray[0] + 1 < len(table.columns[place]) else ""
    return f"only the row of {value} lies out of order{goes_on}: remove line {lines}"


def _reading_runs(table: TraceTable, import_map: ImportMap) -> str:
    """What else can be done with a file of several runs; empty if no column seems to number them."""
    if import_map.run is not None:
        return f"; ema-twin campaign reads each by itself, as the map has `run: {import_map.run.plain}`"
    columns = run_columns(table.header)
    return f"; or, {how_to_read_runs(columns[0])}" if columns else ""


def _steps_in_words(stamps: np.ndarray, resolution: float) -> list[str]:
    """Gaps between stamps [ns] (n,), and unequal steps beyond the ``resolution`` [ns] of the time column."""
    words = []
    period = median(lambda: map(np.diff, overlapping(stamps)))
    gaps = steps_where(lambda steps: steps > 1.5 * period, stamps)
    if gaps.size:
        lengths = stamps[gaps + 1] - stamps[gaps]
        missing = int(np.rint(lengths / period - 1).sum())
        longest = int(np.argmax(lengths))
        words.append(
            f"{missing} samples are missing in {gaps.size} gap{'s' if gaps.size > 1 else ''}, the longest "
            f"{lengths[longest] * 1e-6:g} ms from {stamps[gaps[longest]] * 1e-9:g} s on"
        )
    usual = by_pieces(lambda steps: steps[steps <= 1.5 * period], differences(stamps))
    least, most = extremes(usual)
    if max(period - least, most - period) > max(_UNEQUAL * period, 1.001 * resolution):
        words.append(f"time steps are unequal: {least * 1e-6:g} to {most * 1e-6:g} ms")
    return words


def _stamps(time: np.ndarray, unit: str) -> np.ndarray:
    """Stamps [ns] (n,), from 0 on, from a time column in that unit."""
    first = time[0]
    return by_pieces(lambda part: np.rint((part - first) * TIME_UNITS[unit]).astype(np.int64), time)


def _not_rising(stamps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the samples (m,) whose stamps go back, and of those (k,) that repeat the previous stamp."""
    return steps_where(lambda steps: steps < 0, stamps) + 1, steps_where(lambda steps: steps == 0, stamps) + 1


def _left_out(repeats: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Of the samples (m,) that repeat the previous stamp: a few anywhere, and those after which the clock stopped.

    Both are empty if more of ``count`` samples repeat than a good clock explains.
    """
    none = repeats[:0]
    if repeats.size <= _REPEATED * count:
        return repeats, none
    stopped = _last_run(repeats, count)
    few = repeats[: repeats.size - stopped.size]
    if stopped.size >= _STOPPED * count or few.size > _REPEATED * (count - stopped.size):
        return none, none
    return few, stopped


def _last_run(repeats: np.ndarray, count: int) -> np.ndarray:
    """Those of the indices (m,) that follow each other up to the last of ``count`` samples."""
    if not repeats.size or repeats[-1] != count - 1:
        return repeats[:0]
    breaks = np.flatnonzero(np.diff(repeats) != 1)
    return repeats[int(breaks[-1]) + 1 if breaks.size else 0 :]
