"""Where views go (a file or a viewer), and how curves over time are sent."""

from __future__ import annotations

import ctypes
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
"""Application name under which rerun keeps layouts: the layout of one file is used for the next."""
LIVE_APPLICATION = "ema-twin-live"
"""The same for live views, which have other tabs."""
TIMELINE = "t"
"""Seconds since a recording's first sample."""
_FILE_PATIENCE = 5.0
"""Time in s in which a file must have grown while data is still buffered."""
_VIEWER_PATIENCE = 10.0
"""Time in s in which buffered data must have reached a viewer."""
_ROWS = 1 << 16  # rows of a chunk, so that a viewer draws only what is in sight


@contextmanager
def new_rrd(path: Path, blueprint: rrb.Blueprint, *, force: bool = False) -> Iterator[rr.RecordingStream]:
    """Yield a stream into a file that gets its name when it is complete.

    Raises InputError if the file exists (without ``force``) or cannot be written.
    """
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    with new_file(path, force=force) as file:
        try:
            begin(stream, rr.FileSink(str(file.name)), blueprint)
            yield stream
        except BaseException:
            _give_up(stream)  # the file is deleted too
            raise
        finish_file(stream, path, Path(file.name))


def open_for_writing(path: Path) -> rr.FileSink:
    """A sink into a file that grows as it is written. Raises InputError if it cannot be written."""
    try:
        path.open("wb").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another folder") from None
    return rr.FileSink(str(path))


def begin(
    stream: rr.RecordingStream, sink: rr.FileSink | rr.GrpcSink, blueprint: rrb.Blueprint, *, active: bool = False
) -> None:
    """Start to send to a file or a viewer, the layout first; if ``active``, it replaces the viewer's own."""
    stream.set_sinks(sink)  # with a blueprint as an argument, rerun would wait forever if nobody takes it
    stream.send_blueprint(blueprint, make_active=active, make_default=True)


def finish_file(stream: rr.RecordingStream, path: Path, written: Path | None = None) -> None:
    """Write what is still buffered, and close the file; ``written`` is its path if it does not have its name yet.

    Raises InputError if it cannot be written.
    """
    size = -1
    while True:
        try:
            stream.flush(timeout_sec=_FILE_PATIENCE)
        except RuntimeError:  # a slow or a full disk: rerun does not say which, and may not notice a full one
            before, size = size, (written or path).stat().st_size
            if size == before:
                _give_up(stream)
                raise InputError(
                    f"{path}: could not be written completely; free some space, or choose another folder"
                ) from None
        else:
            stream.disconnect()
            return


def finish_viewer(stream: rr.RecordingStream) -> None:
    """Send what is still buffered, and disconnect from the viewer. Raises RuntimeError if it did not take all."""
    try:
        stream.flush(timeout_sec=_VIEWER_PATIENCE)
    except RuntimeError:
        _give_up(stream)
        raise
    stream.disconnect()


def _give_up(stream: rr.RecordingStream) -> None:
    """Abandon a stream and never free it: rerun would wait forever, both then and at the end of the process."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(stream))
    rr.unregister_shutdown()


def style(stream: rr.RecordingStream, entity: str, name: str, colour: Colour, width: float) -> None:
    """Set how a curve is drawn, and its name."""
    stream.log(entity, rr.SeriesLines(colors=[colour], names=[name], widths=[width]), static=True)


def send(stream: rr.RecordingStream, entity: str, time: np.ndarray, values: np.ndarray) -> None:
    """Send the values (n,) at times [s] (n,), except those that are not finite."""
    time, values = np.asarray(time, np.float64), np.asarray(values, np.float64)
    good = np.isfinite(values)
    if not good.all():
        time, values = time[good], values[good]
    for first in range(0, len(values), _ROWS):
        rows = slice(first, first + _ROWS)
        times = [rr.TimeColumn(TIMELINE, duration=time[rows])]
        stream.send_columns(entity, times, rr.Scalars.columns(scalars=values[rows]))


def path_of(*parts: str) -> str:
    """An entity's path; its parts may contain any characters."""
    return rr.new_entity_path(list(parts))


def send_level(stream: rr.RecordingStream, entity: str, time: Sequence[float] | np.ndarray, level: float) -> None:
    """Send a level line over the times [s] (n,)."""
    if len(time):
        send(stream, entity, np.array([time[0], time[-1]]), np.full(2, level))
