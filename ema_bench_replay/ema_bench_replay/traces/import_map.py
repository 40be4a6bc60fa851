"""Import maps: which column of a text trace is which signal, in which unit. In YAML, so a new drive needs no code."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ema_bench_replay.checked_yaml import Checker, read_yaml
from ema_bench_replay.configuration import find_configuration
from ema_bench_replay.recording import AT_EITHER_SHAFT, MAY_BE_MAGNITUDES, SIGNALS
from ema_bench_replay.units import ALL_UNITS, MOTIONS, units_of, usual_spelling

#: Nanoseconds in one of each unit of time.
TIME_UNITS: dict[str, float] = {"s": 1e9, "ms": 1e6, "us": 1e3, "µs": 1e3, "ns": 1.0}

_POSITIONS = ("motor_position", "output_position")
_COUNTER_KEYS = ("counts_per_revolution", "bits", "maximum_speed", "maximum_acceleration")

# r4821, p1460, r482[1], r482.1, also inside a longer name: the number of a drive's parameter, and an index.
_PARAMETER = re.compile(r"(?<![A-Za-z])[rp]0*(\d+)(?:\[(\d+)\]|\.(\d+))?(?!\d)", re.IGNORECASE)


@dataclass(frozen=True)
class Column:
    """How to find a signal's column: a parameter number, a column name, or a regular expression for it."""

    name: str
    follows: str | None = None  # this column must follow that one; otherwise that one is used instead
    slope: float = 0.0  # and with at least this slope

    @property
    def plain(self) -> str:
        """A column name that this one would match, as far as possible: the regular expression without escapes."""
        plain = re.sub(r"\\(.)", r"\1", self.name)
        return plain if self.find([plain]) else self.name

    @property
    def is_parameter(self) -> bool:
        """Whether it is the number of a drive's parameter, not a column name."""
        return _PARAMETER.fullmatch(self.name) is not None

    def find(self, header: list[str]) -> list[int]:
        """Indices of the columns in `header` that it matches, best first; empty if none."""
        if wanted := _PARAMETER.fullmatch(self.name):
            ranked = sorted((*_rank(wanted, name), place) for place, name in enumerate(header))
            return [place for rank, _, place in ranked if rank == ranked[0][0] < _NO_FIT]
        exactly = [place for place, name in enumerate(header) if name == self.name]  # a T beside the t of the time
        same = exactly or [place for place, name in enumerate(header) if name.lower() == self.name.lower()]
        pattern = re.compile(self.name, re.IGNORECASE)
        return same or [place for place, name in enumerate(header) if pattern.fullmatch(name)]


@dataclass(frozen=True)
class SignalMap:
    """How one signal is read."""

    signal: str
    columns: tuple[Column, ...]  # the first one in the trace is used
    factor: float  # SI value of one of the column's own units (of one count, for a counter)
    counts_per_revolution: float | None = None  # for counters only
    bits: int = 32  # width of that counter
    maximum_speed: float = math.inf  # rad/s of the shaft that carries the counter
    maximum_acceleration: float = math.inf  # rad/s²
    wraps_after: float | None = None  # after how many of the column's own units it starts again; None: after a turn
    at_output: bool = False  # whether it refers to the output shaft; the model has the gear ratio
    write_as: str = ""  # the column's name when a trace is written
    magnitude: bool | None = None  # whether it is a magnitude without sign; None: the map does not say
    less_than: Column | None = None  # the column holds that one minus the signal, in the same unit
    decimals: int | None = None  # of the column when a trace is written; None: as many as needed
    unit: str | None = None  # in which the column is read; None: a counter, or converted by a factor of the map's own

    def finds(self, name: str) -> bool:
        """Whether a column of that name would be read as this signal."""
        return any(column.find([name]) for column in self.columns)


@dataclass(frozen=True)
class ImportMap:
    """A complete map. `text` is its YAML source, which is kept with every recording read through it."""

    name: str
    text: str
    time: Column | None  # None: operating points in the order of their rows
    time_unit: str
    signals: tuple[SignalMap, ...]
    motion: str = "rotary"  # or linear: then positions are m, speeds m/s, torques forces in N
    run: Column | None = None  # run that a row belongs to, if a file holds several
    test: Column | None = None  # test that a row belongs to
    of_points: bool = False  # each row is an operating point: at rest, or at constant speed
    delimiter: str | None = None  # None: detected
    number_format: str | None = None  # "german" or "english"; None: detected
    time_name: str = "X [ms]"  # names of columns when a trace is written
    column_name: str = "{column}"

    def places(self, header: list[str]) -> set[int]:
        """Indices of the columns in a header that may be read."""
        columns = [column for signal in self.signals for column in signal.columns]
        columns += [Column(column.follows) for column in columns if column.follows]
        columns += [signal.less_than for signal in self.signals if signal.less_than]
        columns += [column for column in (self.time, self.run, self.test) if column]
        return {place for column in columns for place in column.find(header)}


def load_map(name_or_path: str | Path) -> ImportMap:
    """Read an import map: the name of a shipped one, or a path. InputError names the file, the place and the remedy."""
    path = find_configuration("maps", name_or_path)
    content, text = read_yaml(path)
    check = Checker(path)
    top = check.mapping(
        content,
        "",
        (
            *("version", "description", "motion", "operating_points", "delimiter", "number_format", "time", "signals"),
            *("column_name", "run", "test"),
        ),
        required=("version", "signals"),
    )
    check.choice(top["version"], "version", (1,))
    of_points = check.boolean(top.get("operating_points", False), "operating_points")
    if "time" not in top and not of_points:
        raise check.error("time", "is missing", "name the column of time, or say `operating_points: true`")
    keys = ("column", "unit")
    time = check.mapping(top["time"], "time", (*keys, "write_as"), required=keys) if "time" in top else {}
    signals = check.mapping(top["signals"], "signals", SIGNALS)
    if not signals:
        raise check.error("signals", "names no signal", f"map at least one of {', '.join(SIGNALS)}")
    motion = check.choice(top.get("motion", "rotary"), "motion", MOTIONS)
    delimiter = check.choice(top.get("delimiter", "auto"), "delimiter", ("auto", ";", ",", "tab"))
    number_format = check.choice(top.get("number_format", "auto"), "number_format", ("auto", "german", "english"))
    time_column = _column(check, time["column"], "time.column") if time else None
    return ImportMap(
        name=path.stem,
        text=text,
        time=time_column,
        time_unit=check.choice(time.get("unit", "s"), "time.unit", TIME_UNITS),
        signals=tuple(_signal(check, name, value, motion) for name, value in signals.items()),
        motion=motion,
        run=_column(check, top["run"], "run") if "run" in top else None,
        test=_column(check, top["test"], "test") if "test" in top else None,
        of_points=of_points,
        delimiter={"auto": None, "tab": "\t"}.get(delimiter, delimiter),
        number_format=None if number_format == "auto" else number_format,
        time_name=check.text(time.get("write_as", time_column.plain), "time.write_as") if time_column else "",
        column_name=check.text(top.get("column_name", "{column}"), "column_name"),
    )


def _signal(check: Checker, name: str, content: Any, motion: str) -> SignalMap:
    place = f"signals.{name}"
    counter_keys = _COUNTER_KEYS if name in _POSITIONS else ()
    shaft_key = ("shaft",) if name in AT_EITHER_SHAFT else ()
    magnitude_key = ("magnitude",) if name in MAY_BE_MAGNITUDES else ()
    position_keys = ("less_than", "wraps_after") if name in _POSITIONS else ()
    keys = ("columns", "unit", "factor", "gain", "write_as", "decimals")
    keys = (*keys, *shaft_key, *magnitude_key, *position_keys, *counter_keys)
    value = check.mapping(content, place, keys, required=("columns",))
    if not isinstance(value["columns"], list) or not value["columns"]:
        raise check.error(f"{place}.columns", "is no list of columns", "write for instance `columns: [r4821]`")
    columns = tuple(_column(check, item, f"{place}.columns[{i}]") for i, item in enumerate(value["columns"]))
    factor = check.number(value.get("factor", 1.0), f"{place}.factor")
    if factor == 0.0:
        raise check.error(f"{place}.factor", "is 0", "give another one, or remove the signal")
    is_counter = "counts_per_revolution" in value
    given = usual_spelling(value.get("unit", next(iter(units_of(name, motion)))))
    unit = given if abs(factor) == 1.0 and not is_counter else None
    for key in ("unit", "gain", "less_than") if is_counter else counter_keys:
        if key in value:
            if is_counter:
                raise check.error(f"{place}.{key}", "does not go with counts_per_revolution", "remove one of them")
            raise check.error(f"{place}.{key}", "belongs to a counter", "add counts_per_revolution, or remove it")
    positive = {
        key: check.number(value[key], f"{place}.{key}", lower=1e-9)
        for key in ("counts_per_revolution", "maximum_speed", "maximum_acceleration")
        if key in value
    }
    if is_counter:
        if motion != "rotary":
            raise check.error(
                f"{place}.counts_per_revolution", "a linear machine's counter has no revolutions",
                "give unit m, and the length of a count as factor",
            )  # fmt: skip
        factor *= 2 * math.pi / positive["counts_per_revolution"]
    else:
        factor *= _in_si(check, value, place, name, motion)
    return SignalMap(
        signal=name,
        columns=columns,
        factor=factor,
        bits=check.choice(value.get("bits", 32), f"{place}.bits", (16, 24, 32)),
        write_as=check.text(value.get("write_as", columns[0].plain), f"{place}.write_as"),
        at_output=check.choice(value.get("shaft", "motor"), f"{place}.shaft", ("motor", "output")) == "output",
        magnitude=check.boolean(value["magnitude"], f"{place}.magnitude") if "magnitude" in value else None,
        less_than=_column(check, value["less_than"], f"{place}.less_than") if "less_than" in value else None,
        decimals=_decimals(check, value.get("decimals", 0 if is_counter else None), f"{place}.decimals"),
        unit=unit,
        wraps_after=_wraps_after(check, value, place, name, motion, factor),
        **positive,
    )


def _wraps_after(
    check: Checker, value: Mapping[str, Any], place: str, signal: str, motion: str, factor: float
) -> float | None:
    """After how many of its own units, each worth ``factor`` in SI units, a column starts again; None if not told."""
    if "wraps_after" not in value:
        return None
    place = f"{place}.wraps_after"
    told = check.mapping(value["wraps_after"], place, ("value", "unit"), required=("value", "unit"))
    units = units_of(signal, motion)
    unit = check.choice(usual_spelling(told["unit"]), f"{place}.unit", units)
    after = check.number(told["value"], f"{place}.value", lower=1e-9) * units[unit] / abs(factor)
    return float(round(after)) if "counts_per_revolution" in value else after


def _decimals(check: Checker, content: Any, place: str) -> int | None:
    return None if content is None else int(check.number(content, place, 0, 12))


def _in_si(check: Checker, value: Mapping[str, Any], place: str, signal: str, motion: str) -> float:
    """SI value of the column's unit; if the column measures another quantity, converted with its ``gain``."""
    allowed = units_of(signal, motion)
    unit = usual_spelling(value.get("unit", next(iter(allowed))))
    if "gain" not in value:
        if unit == "1":  # the column already holds the signal's own unit
            return 1.0
        if unit in ALL_UNITS and unit not in allowed:
            raise check.error(
                f"{place}.unit", f"{unit!r} is no unit of the {signal.replace('_', ' ')} of a {motion} machine",
                f"use one of {', '.join(allowed)}, or say by `gain: {{value: …, unit: {next(iter(allowed))}/{unit}}}` "
                "what one of it is worth",
            )  # fmt: skip
        return allowed[check.choice(unit, f"{place}.unit", allowed)]
    check.choice(unit, f"{place}.unit", ALL_UNITS)
    gain = check.mapping(value["gain"], f"{place}.gain", ("value", "unit"), required=("value", "unit"))
    possible = {f"{own}/{unit}": size for own, size in allowed.items()}
    return (
        check.number(gain["value"], f"{place}.gain.value")
        * possible[check.choice(usual_spelling(gain["unit"]), f"{place}.gain.unit", possible)]
    )


def _column(check: Checker, content: Any, place: str) -> Column:
    if isinstance(content, dict):
        keys = ("column", "follows", "slope")
        value = check.mapping(content, place, keys, required=keys)
        column = Column(
            check.text(value["column"], f"{place}.column"),
            check.text(value["follows"], f"{place}.follows"),
            check.number(value["slope"], f"{place}.slope"),
        )
    else:
        column = Column(check.text(content, place))
    try:
        re.compile(column.name)
    except re.error as error:
        raise check.error(place, f"{column.name!r} is no regular expression ({error})", "escape it") from None
    return column


_NO_FIT = 3


def _rank(wanted: re.Match[str], name: str) -> tuple[int, int]:
    """How well a column's name matches a parameter (0 is best), and its index, to choose among equals.

    Drives also write r4821 as r482[1] or r482.1: number and index.
    """
    found = list(_PARAMETER.finditer(name))
    if not found:
        return _NO_FIT, 0
    number, index = _number_and_index(found[-1])
    wanted_number, wanted_index = _number_and_index(wanted)
    if (number, index) == (wanted_number, wanted_index):
        return 0, 0
    if number + index == wanted_number + wanted_index:
        return 1, 0
    if not wanted_index and number == wanted_number:
        return 2, int(index)
    return _NO_FIT, 0


def _number_and_index(match: re.Match[str]) -> tuple[str, str]:
    return match[1], match[2] or match[3] or ""
