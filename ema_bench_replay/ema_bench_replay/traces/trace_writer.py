"""Write recordings as text traces in the drive's format; `read_trace` reads them back."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ema_bench_replay.outputs import new_file
from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.import_map import TIME_UNITS, ImportMap
from ema_bench_replay.traces.number_format import ENGLISH, FORMATS, GERMAN
from ema_bench_replay.traces.trace_rows import Style

_ROWS = 50_000  # formatted at a time
_MOST_DECIMALS = 24
_ROUNDED = 16.0 * float(np.finfo(float).eps)  # relative to the largest number: rounding of reading and writing


@dataclass(frozen=True)
class _Column:
    name: str
    values: np.ndarray  # in the column's own unit; int64 if it has no decimals
    decimals: int


def write_trace(
    recording: Recording, path: str | Path, import_map: ImportMap, *, force: bool = False
) -> tuple[str, ...]:
    """Write a recording as the text trace that the map reads; returns the signals for which the map has no column.

    A recording that was read through the same map gets its original text back: names and order of its mapped columns,
    decimals, number format, first counts and first time. Others are written with the map's delimiter and number format
    (default German, as on a Siemens drive), names and decimals; without given decimals, with as many as the values
    need. Raises InputError if the file exists (without `force`) or cannot be written.
    """
    kept = recording.metadata.get("text") if recording.metadata.get("map_text") == import_map.text else None
    if kept:
        text = json.loads(kept)
        style, columns = Style(**text["style"]), _kept_columns(recording, import_map, text)
    else:
        style, columns = _map_style(import_map), _map_columns(recording, import_map)
    mapped = {signal.signal for signal in import_map.signals}
    with new_file(Path(path), force=force) as file:
        file.write(_row([column.name for column in columns], style).encode())
        for start in range(0, len(recording), _ROWS):
            file.write(_text(columns, start, style))
    return tuple(name for name in recording.signals if name not in mapped)


def _kept_columns(recording: Recording, import_map: ImportMap, text: dict[str, Any]) -> list[_Column]:
    columns = []
    for column in text["columns"]:
        if column["signal"] == "time":
            values = _time(recording, text.get("time_unit", import_map.time_unit), text["time_origin"])
        elif column["signal"] in recording.signals:
            values = _values(recording, import_map, column["signal"], text["origins"])
        else:
            continue
        # decimals were counted in the first rows, which may have fewer than others
        columns.append(_column(column["name"], values, _decimals(values, column["decimals"])))
    return columns


def _map_columns(recording: Recording, import_map: ImportMap) -> list[_Column]:
    columns = []
    if import_map.time is not None:
        time = _time(recording, import_map.time_unit, 0.0)
        columns.append(_column(import_map.time_name, time, _decimals(time, 1)))
    signals = [signal for signal in import_map.signals if signal.signal in recording.signals]
    for index, signal in enumerate(signals):
        name = import_map.column_name.format(index=index, column=signal.write_as)
        if not signal.finds(name) and signal.finds(signal.write_as):
            name = signal.write_as  # a column given by its whole name has nothing before it
        values = _values(recording, import_map, signal.signal, {})
        columns.append(_column(name, values, _decimals(values, 0) if signal.decimals is None else signal.decimals))
    return columns


def _map_style(import_map: ImportMap) -> Style:
    """Style for a recording that was not read from a trace: one that the map can read."""
    delimiter = import_map.delimiter or ";"
    usual = ENGLISH if delimiter == "," else GERMAN
    form = FORMATS[import_map.number_format] if import_map.number_format else usual
    return Style(delimiter, decimal=form.decimal, thousands="" if form.thousands == delimiter else form.thousands)


def _time(recording: Recording, unit: str, origin: float) -> np.ndarray:
    return recording.stamps / TIME_UNITS[unit] + origin


def _values(recording: Recording, import_map: ImportMap, name: str, origins: dict[str, float]) -> np.ndarray:
    """A signal in its column's unit. Positions are offset by the counter's reading at their zero."""
    factor = next(signal.factor for signal in import_map.signals if signal.signal == name)
    origin = {
        "motor_position": recording.motor_angle_origin,
        "output_position": recording.output_angle_origin,
        "output_command": origins.get("output_command", 0.0),
    }.get(name, 0.0)
    first = 0.0 if np.isnan(origin) else origin / factor
    values = recording.signals[name] / factor
    return values + first if first else values  # keeps -0.0


def _decimals(values: np.ndarray, least: int) -> int:
    """Number of decimals, `least` or more, that represents all values up to rounding of reading and writing."""
    known = values[np.isfinite(values)]
    allowed = _ROUNDED * float(np.abs(known).max(initial=0.0))
    decimals = least
    while decimals < _MOST_DECIMALS and (np.abs(np.round(known, decimals) - known) > allowed).any():
        decimals += 1
    return decimals


def _column(name: str, values: np.ndarray, decimals: int) -> _Column:
    return _Column(name, values if decimals else np.rint(values).astype(np.int64), decimals)


def _text(columns: list[_Column], start: int, style: Style) -> bytes:
    """Rows from `start` on: formatted in English style, then the marks are exchanged."""
    grouped = "," if style.thousands else ""
    cells = [f"{{:{grouped}.{column.decimals}f}}" if column.decimals else f"{{:{grouped}d}}" for column in columns]
    delimiter = "\0"  # differs from both marks until they are exchanged
    line = delimiter.join(cells) + delimiter * style.trailing + style.newline
    lists = [column.values[start : start + _ROWS].tolist() for column in columns]
    english = "".join(map(line.format, *lists)).encode()
    marks = (style.decimal + (style.thousands or ",") + style.delimiter).encode()
    return english.translate(bytes.maketrans(b".,\0", marks))


def _row(cells: list[str], style: Style) -> str:
    return style.delimiter.join(cells) + style.delimiter * style.trailing + style.newline
