"""Recordings to text traces: what `read_trace` reads, written the way the drive writes it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ema_bench_replay.outputs import new_file
from ema_bench_replay.recording import Recording
from ema_bench_replay.traces.import_map import TIME_UNITS, ImportMap
from ema_bench_replay.traces.trace_table import Style

_ROWS = 50_000  # formatted at a time
_MOST_DECIMALS = 9


@dataclass(frozen=True)
class _Column:
    name: str
    values: np.ndarray  # in the column's own unit; int64 where it shows no decimals
    decimals: int


def write_trace(
    recording: Recording, path: str | Path, import_map: ImportMap, *, force: bool = False
) -> tuple[str, ...]:
    """Write a recording as the text trace that the map reads; returns the signals that the map has no column for.

    A recording that was read through the same map gets its own text back: names and order of its mapped columns,
    decimals, number format, first counts and first time. Others are written as a German Siemens trace, with the map's
    names and decimals. Raises InputError where the file exists (without `force`) or cannot be written.
    """
    kept = recording.metadata.get("text") if recording.metadata.get("map_text") == import_map.text else None
    if kept:
        text = json.loads(kept)
        style, columns = Style(**text["style"]), _kept_columns(recording, import_map, text)
    else:
        style, columns = Style(), _map_columns(recording, import_map)
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
            values = _time(recording, import_map, column["decimals"], text["time_origin"])
        elif column["signal"] in recording.signals:
            values = _values(recording, import_map, column["signal"], column["decimals"], text["origins"])
        else:
            continue
        columns.append(_Column(column["name"], values, column["decimals"]))
    return columns


def _map_columns(recording: Recording, import_map: ImportMap) -> list[_Column]:
    unit = TIME_UNITS[import_map.time_unit]
    decimals = 1
    while decimals < _MOST_DECIMALS and (recording.stamps % max(unit * 10.0**-decimals, 1.0)).any():
        decimals += 1
    columns = [_Column(import_map.time_name, _time(recording, import_map, decimals, 0.0), decimals)]
    for signal in import_map.signals:
        if signal.signal in recording.signals:
            name = import_map.column_name.format(index=len(columns) - 1, column=signal.write_as)
            values = _values(recording, import_map, signal.signal, signal.decimals, {})
            columns.append(_Column(name, values, signal.decimals))
    return columns


def _time(recording: Recording, import_map: ImportMap, decimals: int, origin: float) -> np.ndarray:
    time = recording.stamps / TIME_UNITS[import_map.time_unit] + origin
    return time if decimals else np.rint(time).astype(np.int64)


def _values(
    recording: Recording, import_map: ImportMap, name: str, decimals: int, origins: dict[str, float]
) -> np.ndarray:
    """A signal in its column's unit. Positions are counted from where the counter stood at their zero."""
    factor = next(signal.factor for signal in import_map.signals if signal.signal == name)
    origin = {
        "motor_position": recording.motor_angle_origin,
        "output_position": recording.output_angle_origin,
        "output_command": origins.get("output_command", 0.0),
    }.get(name, 0.0)
    first = 0.0 if np.isnan(origin) else origin / factor
    values = recording.signals[name] / factor
    if decimals:
        return values + first if first else values  # -0.0 stays what it is
    return np.rint(values).astype(np.int64) + round(first)


def _text(columns: list[_Column], start: int, style: Style) -> bytes:
    """Rows from `start` on: written the English way, then the marks are exchanged."""
    grouped = "," if style.thousands else ""
    cells = [f"{{:{grouped}.{column.decimals}f}}" if column.decimals else f"{{:{grouped}d}}" for column in columns]
    delimiter = "\0"  # stands apart from both marks until they are exchanged
    line = delimiter.join(cells) + delimiter * style.trailing + style.newline
    lists = [column.values[start : start + _ROWS].tolist() for column in columns]
    english = "".join(map(line.format, *lists)).encode()
    marks = (style.decimal + (style.thousands or ",") + style.delimiter).encode()
    return english.translate(bytes.maketrans(b".,\0", marks))


def _row(cells: list[str], style: Style) -> str:
    return style.delimiter.join(cells) + style.delimiter * style.trailing + style.newline
