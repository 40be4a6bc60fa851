"""Text traces (the Siemens drive's CSV, or any other described by an import map) to recordings, and back."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from ema_bench_replay.errors import InputError
from ema_bench_replay.long_columns import (
    by_pieces,
    mean_of,
    pieces,
    places_where,
    shifted,
    times,
)
from ema_bench_replay.recording import AT, KIND, LACKED, MAGNITUDE, MOTION, POINTS, SIGNED, Recording
from ema_bench_replay.some_of import some_of
from ema_bench_replay.traces.counters import unwrap_counts
from ema_bench_replay.traces.header_units import contradicted_unit
from ema_bench_replay.traces.import_map import Column, ImportMap, SignalMap
from ema_bench_replay.traces.trace_clock import Clock, read_clock
from ema_bench_replay.traces.trace_table import TraceTable, read_table
from ema_bench_replay.traces.wrapped_angle import counted_on, unwrapped

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


def column_of(table: TraceTable, column: Column, use: str) -> np.ndarray:
    """A column (n,) of a table by the map. Raises InputError, which tells its ``use``, if there is none."""
    places = column.find(table.header)
    if not places:
        raise InputError(
            f"{table.path}: line {table.header_line}: no column {column.plain!r}{use}; name the right one in the "
            "import map"
        )
    return table.columns[places[0]]


class _Trace:
    """Conversion of one trace to a recording."""

    def __init__(self, table: TraceTable, import_map: ImportMap) -> None:
        self.table = table
        self.map = import_map
        self.warnings = list(table.warnings)
        self.columns: dict[str, int] = {}  # signal: its place in the table
        self.origins: dict[str, float] = {}  # position: rad where it is zero

    def recording(self) -> Recording:
        clock = read_clock(self.table, self.map)
        self.table = clock.table
        for finding in clock.findings:
            self._warn(finding)
        maps = {signal.signal: signal for signal in self.map.signals}
        for signal in self.map.signals:
            place = self._place(signal)
            if place is not None:
                self.columns[signal.signal] = place
                self._report_unit(signal, self.table.header[place])
        if not self.columns:
            known = some_of(column.plain for signal in self.map.signals for column in signal.columns)
            raise InputError(
                f"{self.table.path}: header: none of the columns of the map {self.map.name!r} ({known}) is there; "
                f"name the right map with --map, or let one be written: ema-twin init {self.table.path} -o NAME"
            )
        time = times(clock.stamps, 1e-9)
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
            stamps=clock.stamps,
            signals=signals,
            motor_angle_origin=self.origins.get("motor_position", np.nan),
            output_angle_origin=self.origins.get("output_position", np.nan),
            metadata=self._metadata(clock),
            warnings=tuple(self.warnings),
        )

    def _place(self, signal: SignalMap) -> int | None:
        """Index of the signal's column in the table; None if there is none."""
        for column in signal.columns:
            places = column.find(self.table.header)
            if not places:
                continue
            place = places[0]
            if len(places) > 1:
                names = some_of(f"{self.table.header[other]} in column {other + 1}" for other in places)
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
                f"{signal.signal.replace('_', ' ')} in {signal.unit}; write `unit: {told}` into the map or, if the "
                "header is wrong, correct it and run init again"
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
            use = f", which the {signal.signal.replace('_', ' ')} is less than"
            values = by_pieces(np.subtract, column_of(self.table, signal.less_than, use), values)
        if signal.wraps_after:
            values = self._unwrapped(values, signal.wraps_after, signal.unit or "", self.table.header[place])
        elif signal.signal in ("motor_position", "output_position") and self.map.motion == "rotary":
            values = self._counted_on(values, 2.0 * np.pi / abs(signal.factor), self.table.header[place])
        if signal.counts_per_revolution:
            values = self._counts(signal, signal.counts_per_revolution, place, values, time)
        if signal.signal not in ("motor_position", "output_position"):
            return times(values, signal.factor)
        first = values[0]
        self.origins[signal.signal] = float(first * signal.factor)
        return by_pieces(lambda part: (part - first) * signal.factor, values)

    def _counted_on(self, values: np.ndarray, turn: float, name: str) -> np.ndarray:
        """Unwrap an angle (n,) that restarts after each ``turn``, in its own unit."""
        on, turns = counted_on(values, turn)
        if turns:
            self._warn(f"{name} begins again after {turn:.6g}, a turn, {turns} times: repaired, counted on")
        return on

    def _unwrapped(self, values: np.ndarray, period: float, unit: str, name: str) -> np.ndarray:
        """Unwrap a position (n,) that by the map starts again after each ``period``, in its own unit."""
        on, times_wrapped = unwrapped(values, period)
        if times_wrapped:
            after = f"{period:.6g} {unit}".rstrip()
            self._warn(
                f"{name} begins again after {after} (`wraps_after` of the map), {times_wrapped} times: repaired, "
                "counted on"
            )
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

    def _metadata(self, clock: Clock) -> dict[str, str]:
        signal_of = {place: name for name, place in reversed(self.columns.items())}
        columns = [
            {"name": name, "signal": "time" if place == clock.place else signal_of.get(place), "decimals": decimals}
            for place, (name, decimals) in enumerate(zip(self.table.header, self.table.decimals, strict=True))
        ]
        style = asdict(self.table.style)
        text = {
            "columns": columns,
            "time_origin": clock.origin,
            "time_unit": clock.unit,
            "origins": self.origins,
            "style": style,
        }
        at_output = [signal.signal for signal in self.map.signals if signal.at_output and signal.signal in self.columns]
        return {
            **{f"{signal}{AT}": "output" for signal in at_output},
            **{
                f"{s.signal}{KIND}": MAGNITUDE if s.magnitude else SIGNED
                for s in self.map.signals
                if s.magnitude is not None and s.signal in self.columns
            },
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
