"""Where views go: a file, a viewer, or both; and how curves over time are sent."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ema_bench_replay.errors import InputError
from ema_bench_replay.outputs import new_file

from .palette import Colour

APPLICATION = "ema-twin"
"""What rerun keeps layouts under: that of one file serves the next."""
LIVE_APPLICATION = "ema-twin-live"
"""The same for live views, which have other tabs."""
TIMELINE = "t"
"""Seconds since a recording's first sample."""
_ROWS = 1 << 16  # of a chunk, so that a viewer draws what is in sight and no more


@contextmanager
def new_rrd(path: Path, blueprint: rrb.Blueprint, *, force: bool = False) -> Iterator[rr.RecordingStream]:
    """A stream into a file that takes its name when it is whole.

    Raises InputError where the file exists (without ``force``) or cannot be written.
    """
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    with new_file(path, force=force) as file:
        stream.set_sinks(rr.FileSink(str(file.name)), default_blueprint=blueprint)
        try:
            yield stream
        finally:
            stream.flush()
            stream.disconnect()


def open_for_writing(path: Path) -> rr.FileSink:
    """A sink into a file that grows as it is written. Raises InputError where it cannot be written."""
    try:
        path.open("wb").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another folder") from None
    return rr.FileSink(str(path))


def style(stream: rr.RecordingStream, entity: str, name: str, colour: Colour, width: float) -> None:
    """How a curve is drawn, and the name that it bears."""
    stream.log(entity, rr.SeriesLines(colors=[colour], names=[name], widths=[width]), static=True)


def send(stream: rr.RecordingStream, entity: str, time: np.ndarray, values: np.ndarray) -> None:
    """The values (n,) at times [s] (n,), but for those that are not finite."""
    time, values = np.asarray(time, np.float64), np.asarray(values, np.float64)
    good = np.isfinite(values)
    if not good.all():
        time, values = time[good], values[good]
    for first in range(0, len(values), _ROWS):
        rows = slice(first, first + _ROWS)
        times = [rr.TimeColumn(TIMELINE, duration=time[rows])]
        stream.send_columns(entity, times, rr.Scalars.columns(scalars=values[rows]))


def path_of(*parts: str) -> str:
    """An entity's path, whatever letters its parts hold."""
    return rr.new_entity_path(list(parts))


def send_level(stream: rr.RecordingStream, entity: str, time: Sequence[float] | np.ndarray, level: float) -> None:
    """A level line over the times [s] (n,)."""
    if len(time):
        send(stream, entity, np.array([time[0], time[-1]]), np.full(2, level))
