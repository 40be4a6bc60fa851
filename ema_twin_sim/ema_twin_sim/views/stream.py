"""Where views go: a file, a viewer, or both; and how curves over time are sent."""

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
"""What rerun keeps layouts under: that of one file serves the next."""
LIVE_APPLICATION = "ema-twin-live"
"""The same for live views, which have other tabs."""
TIMELINE = "t"
"""Seconds since a recording's first sample."""
_FILE_PATIENCE = 5.0
"""s in which a file must have grown, as long as something is held back."""
_VIEWER_PATIENCE = 10.0
"""s in which what is held back must have reached a viewer."""
_ROWS = 1 << 16  # of a chunk, so that a viewer draws what is in sight and no more


@contextmanager
def new_rrd(path: Path, blueprint: rrb.Blueprint, *, force: bool = False) -> Iterator[rr.RecordingStream]:
    """A stream into a file that takes its name when it is whole.

    Raises InputError where the file exists (without ``force``) or cannot be written.
    """
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    with new_file(path, force=force) as file:
        try:
            begin(stream, rr.FileSink(str(file.name)), blueprint)
            yield stream
        except BaseException:
            _give_up(stream)  # the file goes too
            raise
        finish_file(stream, path, Path(file.name))


def open_for_writing(path: Path) -> rr.FileSink:
    """A sink into a file that grows as it is written. Raises InputError where it cannot be written."""
    try:
        path.open("wb").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); choose another folder") from None
    return rr.FileSink(str(path))


def begin(
    stream: rr.RecordingStream, sink: rr.FileSink | rr.GrpcSink, blueprint: rrb.Blueprint, *, active: bool = False
) -> None:
    """Send to a file or a viewer from now on, the layout first: where ``active``, in place of the viewer's own."""
    stream.set_sinks(sink)  # given a blueprint too, rerun would wait without end for who does not take it
    stream.send_blueprint(blueprint, make_active=active, make_default=True)


def finish_file(stream: rr.RecordingStream, path: Path, written: Path | None = None) -> None:
    """Write what is held back, and let go of the file; ``written`` where it has not its name yet.

    Raises InputError where it cannot be written.
    """
    size = -1
    while True:
        try:
            stream.flush(timeout_sec=_FILE_PATIENCE)
        except RuntimeError:  # a slow disk, or a full one: rerun does not tell which, nor does it always see the latter
            before, size = size, (written or path).stat().st_size
            if size == before:
                _give_up(stream)
                raise InputError(f"{path}: cannot be written to its end; make room, or choose another folder") from None
        else:
            stream.disconnect()
            return


def finish_viewer(stream: rr.RecordingStream) -> None:
    """Send what is held back, and let go of the viewer. Raises RuntimeError where it did not take all."""
    try:
        stream.flush(timeout_sec=_VIEWER_PATIENCE)
    except RuntimeError:
        _give_up(stream)
        raise
    stream.disconnect()


def _give_up(stream: rr.RecordingStream) -> None:
    """Leave a stream as it is, never freed: there, and where the process ends, rerun would wait without end."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(stream))
    rr.unregister_shutdown()


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
