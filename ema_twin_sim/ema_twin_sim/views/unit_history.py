"""A unit's history in rerun: its numbers with their errors, healthy levels and limits, and its health test by test."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..campaign.histories import Outlook
from ..campaign.unit_health import UnitHealth
from ..quantities import axis_unit
from ..words.units import number_words
from .palette import AFTER, BEFORE, FAINT, GOOD
from .recording_views import layout
from .stream import new_rrd, path_of, send, send_level, style

_DAY = 86400.0  # s
_ROOT, _HEALTH = "numbers", "health"


def write_unit_history(
    path: Path, looks: Sequence[Outlook], health: UnitHealth | None, *, force: bool = False
) -> list[str]:
    """Write it as an .rrd; return the names of its tabs.

    Time is that since a number's first value; if results are not dated, one second stands for each. In the tab of
    health, one second stands for each recording. Raises InputError if the file exists (without ``force``) or cannot be
    written.
    """
    runs = () if health is None else tuple(run for test in health.tests for run in test.runs if run.changes)
    names = list(dict.fromkeys(change.name for run in runs for change in run.changes))
    tabs: list[rrb.Container] = []
    if looks:
        views = [rrb.TimeSeriesView(origin=path_of(_ROOT, look.history.path), name=_title(look)) for look in looks]
        tabs.append(rrb.Grid(*views, name="numbers"))
    if runs:
        words = {name: f"{name.replace('_', ' ')} [standard deviations]" for name in names}
        words = {"distance": "distance (1 = limit)", **words}
        views = [rrb.TimeSeriesView(origin=path_of(_HEALTH, of), name=word) for of, word in words.items()]
        tabs.append(rrb.Grid(*views, name="health"))
    with new_rrd(path, layout(tabs), force=force) as stream:
        for look in looks:
            _log_number(stream, look)
        place = np.arange(len(runs), dtype=float)
        if runs:
            at = path_of(_HEALTH, "distance")
            _curve(stream, f"{at}/run", "each recording", place, np.array([run.distance for run in runs]))
            _level(stream, f"{at}/limit", "limit", place, 1.0, BEFORE)
        for name in names:
            held = [{change.name: change.standard_deviations for change in run.changes} for run in runs]
            values = np.array([of.get(name, np.nan) for of in held])
            _curve(stream, f"{path_of(_HEALTH, name)}/run", "each recording", place, values)
            _level(stream, f"{path_of(_HEALTH, name)}/healthy", "healthy", place, 0.0, GOOD)
    return [str(tab.name) for tab in tabs]


def _title(look: Outlook) -> str:
    return f"{number_words(look)} [{_scale(look)[1]}]"


def _scale(look: Outlook) -> tuple[float, str]:
    return axis_unit(float(np.abs(look.history.values).max()), look.history.unit)


def _log_number(stream: rr.RecordingStream, look: Outlook) -> None:
    of, at, scale = look.history, path_of(_ROOT, look.history.path), _scale(look)[0]
    time = of.times * (_DAY if of.dated else 1.0)
    _curve(stream, f"{at}/value", "value", time, of.values / scale)
    for name, side in (("above", 1.0), ("below", -1.0)):
        style(stream, f"{at}/{name}", "one standard error", FAINT, 0.8)
        send(stream, f"{at}/{name}", time, (of.values + side * of.errors) / scale)
    _level(stream, f"{at}/healthy", "healthy", time, look.healthy / scale, GOOD)
    if look.limit is not None:
        _level(stream, f"{at}/limit", "limit", time, look.limit / scale, BEFORE)


def _curve(stream: rr.RecordingStream, entity: str, name: str, time: np.ndarray, values: np.ndarray) -> None:
    style(stream, entity, name, AFTER, 1.8)
    send(stream, entity, time, values)


def _level(
    stream: rr.RecordingStream, entity: str, name: str, time: np.ndarray, level: float, colour: tuple[int, int, int]
) -> None:
    style(stream, entity, name, colour, 1.2)
    send_level(stream, entity, time, level)
