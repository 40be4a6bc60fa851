"""Text traces (the Siemens drive's CSV, or any other described by an import map) to recordings, and back."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import asdict
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from ema_bench_replay.errors import InputError, TimeGoesBackError
from ema_bench_replay.long_columns import (
    by_pieces,
    differences,
    extremes,
    mean_of,
    median,
    overlapping,
    pieces,
    places_where,
    shifted,
    steps_where,
    times,
)
from ema_bench_replay.recording import AT, KIND, LACKED, MOTION, POINTS, Recording
from ema_bench_replay.traces.counters import unwrap_counts
from ema_bench_replay.traces.header_units import contradicted_unit
from ema_bench_replay.traces.import_map import TIME_UNITS, Column, ImportMap, SignalMap
from ema_bench_replay.traces.run_columns import how_to_read_runs, run_columns
from ema_bench_replay.traces.trace_table import TraceTable, read_table
from ema_bench_replay.traces.wrapped_angle import counted_on

# A step differs from the usual one if it is off by more than this share and by more than the time column resolves.
_UNEQUAL = 0.01
# Share of rows that may repeat the time of the row before: a clock too coarse for its sampling. More means it is stuck.
_REPEATED = 0.1
# Share of rows at the end that may all tell the same time: a clock that stopped before the log did.
_STOPPED = 0.5
# Similarity of two names (difflib's ratio) from which one may be a misspelling of the other.
_NEARLY_THE_SAME = 0.85
# Signals without which a twin is compared with less than its recording was made for.
_NEEDED = frozenset({"motor_position", "output_position", "speed", "current", "motor_torque"})


def read_trace(
    path: str | Path, import_map: ImportMap, progress: Callable[[float], None] = lambda share: None
) -> Recording:
    """Read a text trace through an import map.

    Both positions begin at zero; the counter readings there are kept as angle origins. All other values are those of
    the text times the unit's SI value. The metadata hold source, hash and map, and what `write_trace` needs to write
    the same text again. Findings (jumps, gaps, an incomplete last row) are in the recording's warnings. `progress` is
    called with the share read so far. Raises InputError.
    """
    path = Path(path)
    table = read_table(path, import_map.delimiter, import_map.number_format, import_map.places, progress)
    return recording_of(table, import_map)


def recording_of(table: TraceTable, import_map: ImportMap) -> Recording:
    """The recording in a table, or in a part of one."""
    return _Trace(table, import_map).recording()


class _Trace:
    """Conversion of one trace to a recording."""

    def __init__(self, table: TraceTable, import_map: ImportMap) -> None:
        self.table = table
        self.map = import_map
        self.warnings = list(table.warnings)
        self.columns: dict[str, int] = {}  # signal: its place in the table
        self.origins: dict[str, float] = {}  # position: rad where it is zero

    def recording(self) -> Recording:
        time_place, stamps, time_origin, time_unit = self._time()
        maps = {signal.signal: signal for signal in self.map.signals}
        for signal in self.map.signals:
            place = self._place(signal)
            if place is not None:
                self.columns[signal.signal] = place
                self._report_unit(signal, self.table.header[place])
        if not self.columns:
            known = ", ".join(column.plain for signal in self.map.signals for column in signal.columns)
            raise InputError(
                f"{self.table.path}: header: none of the columns of the map {self.map.name!r} ({known}) is there; "
                f"name the right map with --map, or let one be written: ema-twin init {self.table.path} -o NAME"
            )
        time = times(stamps, 1e-9)
        signals = {name: self._values(maps[name], time) for name in self.columns}
        if "output_command" in signals:
            # Relative to the output position's zero if both have the same scale, otherwise to its own start.
            beside = "output_position" if "output_position" in signals else "motor_position"
            same_scale = beside in signals and not maps[beside].counts_per_revolution
            zero = self.origins[beside] if same_scale else signals["output_command"][0]
            signals["output_command"] = shifted(signals["output_command"], -zero)
            self.origins["output_command"] = float(zero)
        return Recording(
            name=self.table.path.stem,
            stamps=stamps,
            signals=signals,
            motor_angle_origin=self.origins.get("motor_position", np.nan),
            output_angle_origin=self.origins.get("output_position", np.nan),
            metadata=self._metadata(time_place, time_origin, time_unit),
            warnings=tuple(self.warnings),
        )

    def _time(self) -> tuple[int | None, np.ndarray, float, str]:
        """Index of the time column, stamps in ns from 0, the column's value at the first sample, and its unit.

        Operating points may have no time column: then they are one second apart.
        """
        table = self.table
        if self.map.time is None:
            return None, np.arange(len(table.columns[0]), dtype=np.int64) * int(TIME_UNITS["s"]), 0.0, "s"
        places = self.map.time.find(table.header)
        if not places:
            shown = ", ".join(table.header)[:200]
            raise InputError(
                f"{table.path}: line {table.header_line}: no time column ({self.map.time.name}) among {shown!r}; "
                "give the map of this machine with --map (init writes one), or export the trace with its time axis"
            )
        name = table.header[places[0]]
        in_brackets = re.search(r"[\[(]\s*([^\])]+?)\s*[\])]", name)
        unit = in_brackets[1] if in_brackets and in_brackets[1] in TIME_UNITS else self.map.time_unit
        stamps = _stamps(table.columns[places[0]], unit)
        back, repeats = _not_rising(stamps)
        few, stopped = _left_out(repeats, len(stamps))
        if few.size + stopped.size and not back.size:
            if stopped.size:
                last = stopped[0] - 1
                self._warn(
                    f"the clock stops in line {table.line(last)}, at {table.columns[places[0]][last]:.10g} {unit}: the "
                    f"{stopped.size} rows below it, which tell the same time, are left out"
                )
            if few.size:
                those = "rows" if few.size > 1 else "row"
                tell = "tell" if few.size > 1 else "tells"
                self._warn(
                    f"{few.size} {those} (the first in line {table.line(few[0])}) {tell} the time of the row before: "
                    "left out"
                )
            self.table = table = table.without(repeats)
            stamps = _stamps(table.columns[places[0]], unit)
            back, repeats = _not_rising(stamps)
        values = table.columns[places[0]]
        if back.size or repeats.size:
            row = int(back[0] if back.size else repeats[0])
            how, remedy = "goes back", f"cut the file there, it holds more than one run{self._how_to_read_runs()}"
            if back.tolist() == [1]:
                remedy = f"only the first row is late: remove line {table.line(0)}"
            if not back.size:
                how, remedy = "repeats", f"{repeats.size} of {len(values)} rows do: export it with more decimals"
                if (stopped := _last_run(repeats, len(values))).size >= max(2.0, _STOPPED * len(values)):
                    row = int(stopped[0])
                    how, remedy = "stops", f"all {stopped.size} rows from here on tell the same: cut them off"
            shown = f"{values[row]:.10g} {unit} after {values[row - 1]:.10g} {unit}"
            said = f"{table.place(row)}: column {name!r}: time {how} ({shown}); {remedy}"
            raise TimeGoesBackError(said, len(values)) if back.size else InputError(said)
        if len(stamps) < 2:
            raise InputError(f"{table.path}: has one row only; a recording needs at least two")
        resolution = TIME_UNITS[unit] * 10.0 ** -table.decimals[places[0]]
        if not self.map.of_points:
            self._report_steps(stamps, resolution)
        return places[0], stamps, float(values[0]), unit

    def _how_to_read_runs(self) -> str:
        """What else can be done with a file of several runs; empty if no column seems to number them."""
        if self.map.run is not None:
            return f"; ema-twin campaign reads each by itself, as the map has `run: {self.map.run.plain}`"
        columns = run_columns(self.table.header)
        return f"; or, {how_to_read_runs(columns[0])}" if columns else ""

    def _report_steps(self, stamps: np.ndarray, resolution: float) -> None:
        period = median(lambda: map(np.diff, overlapping(stamps)))
        gaps = steps_where(lambda steps: steps > 1.5 * period, stamps)
        if gaps.size:
            lengths = stamps[gaps + 1] - stamps[gaps]
            missing = int(np.rint(lengths / period - 1).sum())
            longest = int(np.argmax(lengths))
            self._warn(
                f"{missing} samples are missing in {gaps.size} gap{'s' if gaps.size > 1 else ''}, the longest "
                f"{lengths[longest] * 1e-6:g} ms from {stamps[gaps[longest]] * 1e-9:g} s on"
            )
        usual = by_pieces(lambda steps: steps[steps <= 1.5 * period], differences(stamps))
        least, most = extremes(usual)
        if max(period - least, most - period) > max(_UNEQUAL * period, 1.001 * resolution):
            self._warn(f"time steps are unequal: {least * 1e-6:g} to {most * 1e-6:g} ms")

    def _place(self, signal: SignalMap) -> int | None:
        """Index of the signal's column in the table; None if there is none."""
        for column in signal.columns:
            places = column.find(self.table.header)
            if not places:
                continue
            place = places[0]
            if len(places) > 1:
                names = ", ".join(f"{self.table.header[other]} in column {other + 1}" for other in places)
                self._warn(f"{column.name} is in {len(places)} columns ({names}); column {place + 1} is used")
            return self._following(column, place, signal.signal)
        self._report_missing(signal)
        return None

    def _report_missing(self, signal: SignalMap) -> None:
        """Warn that none of this signal's columns is there, with the nearest name of a column that no signal reads.

        A drive's parameters are traced or not, as chosen for each trace: they are not missed. Nor is a signal that
        nothing needs, unless a column has nearly its name.
        """
        if any(column.is_parameter for column in signal.columns):
            return
        header, read = self.table.header, self.map.places(self.table.header)
        spare = {name.lower(): name for place, name in enumerate(header) if name and place not in read}
        signal_words = signal.signal.replace("_", " ")
        missed = _named(signal)
        near = [
            spare[name]
            for column in signal.columns
            for name in get_close_matches(column.plain.lower(), spare, n=1, cutoff=_NEARLY_THE_SAME)
        ]
        if not near and signal.signal not in _NEEDED:
            return
        remedy = f"correct the map if {near[0]!r} is meant" if near else "the recording is read without it"
        none = "which is not" if len(signal.columns) == 1 else "none of which is"
        self._warn(f"the map {self.map.name!r} reads the {signal_words} from {missed}, {none} there; {remedy}")

    def _report_unit(self, signal: SignalMap, column: str) -> None:
        """Warn if the column's header tells another unit than the map."""
        if told := contradicted_unit(column, signal.signal, signal.unit):
            self._warn(
                f"the column {column!r} is in {told} by its name, but the map {self.map.name!r} reads it as the "
                f"{signal.signal.replace('_', ' ')} in {signal.unit}; write `unit: {told}` into the map, or correct "
                "the header"
            )

    def _following(self, column: Column, place: int, signal: str) -> int:
        """The column at `place`, or the one that it should follow if it does not follow it."""
        leaders = Column(column.follows).find(self.table.header) if column.follows else []
        if not leaders:
            return place
        slope, error = _slope(self.table.columns[leaders[0]], self.table.columns[place])
        if slope + 3 * error >= column.slope:
            return place
        if slope <= -column.slope:
            self._warn(
                f"{column.name} runs against {column.follows} (slope {slope:.2f}): its sign is turned round. Give it "
                f"`factor: -1` in the import map; until then {column.follows} is used in its stead"
            )
            return leaders[0]
        self._warn(
            f"{column.name} hardly follows {column.follows} (slope {slope:.2f}, less than {column.slope:g}), so it is "
            f"not the {signal.replace('_', ' ')}; {column.follows} is used in its stead"
        )
        return leaders[0]

    def _values(self, signal: SignalMap, time: np.ndarray) -> np.ndarray:
        """A signal in SI units; positions from zero on."""
        place = self.columns[signal.signal]
        values = self.table.columns[place]
        if signal.less_than:
            values = by_pieces(np.subtract, self._whole(signal.less_than, signal.signal), values)
        if signal.signal in ("motor_position", "output_position") and self.map.motion == "rotary":
            values = self._counted_on(values, 2.0 * np.pi / abs(signal.factor), self.table.header[place])
        if signal.counts_per_revolution:
            values = self._counts(signal, signal.counts_per_revolution, place, values, time)
        if signal.signal not in ("motor_position", "output_position"):
            return times(values, signal.factor)
        first = values[0]
        self.origins[signal.signal] = float(first * signal.factor)
        return by_pieces(lambda part: (part - first) * signal.factor, values)

    def _whole(self, column: Column, signal: str) -> np.ndarray:
        """The reference column (n,) from which the signal's column is subtracted."""
        places = column.find(self.table.header)
        if not places:
            raise InputError(
                f"{self.table.path}: line {self.table.header_line}: no column {column.plain!r}, which the "
                f"{signal.replace('_', ' ')} is less than; name the right one in the import map"
            )
        return self.table.columns[places[0]]

    def _counted_on(self, values: np.ndarray, turn: float, name: str) -> np.ndarray:
        """Unwrap an angle (n,) that restarts after each ``turn``, in its own unit."""
        on, turns = counted_on(values, turn)
        if turns:
            self._warn(f"{name} begins again after {turn:.6g}, a turn, {turns} times: repaired, counted on")
        return on

    def _counts(
        self, signal: SignalMap, per_revolution: float, place: int, values: np.ndarray, time: np.ndarray
    ) -> np.ndarray:
        name = self.table.header[place]
        fractions = places_where(lambda part: part != part.astype(np.int64), values)
        if fractions.size:
            row = int(fractions[0])
            self._warn(f"line {self.table.line(row)}: {name} is a counter but shows fractions ({values[row]:.10g})")
        else:
            values = by_pieces(lambda part: part.astype(np.int64), values)
        counts, findings = unwrap_counts(
            values,
            time,
            per_revolution,
            bits=signal.bits,
            maximum_speed=signal.maximum_speed,
            maximum_acceleration=signal.maximum_acceleration,
        )
        for finding in findings:
            self._warn(f"{name}: {finding.describe(time[finding.sample])}")
        return counts

    def _metadata(self, time_place: int | None, time_origin: float, time_unit: str) -> dict[str, str]:
        signal_of = {place: name for name, place in reversed(self.columns.items())}
        columns = [
            {"name": name, "signal": "time" if place == time_place else signal_of.get(place), "decimals": decimals}
            for place, (name, decimals) in enumerate(zip(self.table.header, self.table.decimals, strict=True))
        ]
        style = asdict(self.table.style)
        text = {
            "columns": columns,
            "time_origin": time_origin,
            "time_unit": time_unit,
            "origins": self.origins,
            "style": style,
        }
        at_output = [signal.signal for signal in self.map.signals if signal.at_output and signal.signal in self.columns]
        return {
            **{f"{signal}{AT}": "output" for signal in at_output},
            **{f"{s.signal}{KIND}": "magnitude" for s in self.map.signals if s.magnitude and s.signal in self.columns},
            **{f"{s.signal}{LACKED}": _named(s) for s in self.map.signals if s.signal in _NEEDED - {*self.columns}},
            **({MOTION: self.map.motion} if self.map.motion != "rotary" else {}),
            **({POINTS: "yes"} if self.map.of_points else {}),
            "source": self.table.path.name,
            "sha256": self.table.sha256,
            "map": self.map.name,
            "map_text": self.map.text,
            "text": json.dumps(text),
        }

    def _warn(self, message: str) -> None:
        self.warnings.append(f"{self.table.path.name}: {message}")


def _named(signal: SignalMap) -> str:
    """The columns from which a map reads a signal, in words."""
    return " or ".join(repr(column.plain) for column in signal.columns)


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


def _slope(leader: np.ndarray, follower: np.ndarray) -> tuple[float, float]:
    """Slope of the follower's regression on its leader, and its standard error (infinite if the leader is constant)."""
    of_leader, of_follower = mean_of(leader), mean_of(follower)
    x, y = shifted(leader, -of_leader), shifted(follower, -of_follower)
    square = _product(x, x)
    if not square:
        return 0.0, np.inf
    slope = _product(x, y) / square
    left = by_pieces(lambda one, other: other - slope * one, x, y)
    return slope, float(np.sqrt(_product(left, left) / max(len(x) - 2, 1) / square))


def _product(one: np.ndarray, other: np.ndarray) -> float:
    return float(sum(one[rows] @ other[rows] for rows in pieces(len(one))))
