"""Limits of axes on which the error of the first model, if its numbers are guesses, would hide those of the others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..model import Model
from .chart import BEFORE, Trace
from .content import Shown

_HIDES = 5.0  # times as far as the others, from which on a guess hides them
_RUNS_AWAY = 3.0  # times the measured signal, from which on an error says that the twin runs away
_ROOM = 0.15  # of the range, to either side
_QUARTERS = "error_y"


def hides_the_rest(given: Shown, model: Model, name: str) -> bool:
    """Whether the error of the first ``model`` hides those of the others, and only says that its numbers are guesses.

    That is so if they are start values of a fit, or if its error is far larger than the signal itself.
    """
    first, *others = [[each.curves[name] for each in curves if name in each.curves] for curves in given.curves]
    if not others or not first:
        return False
    sizes = [largest(*(curve.residual for curve in curves)) for curves in (first, *others)]
    guessed = model.is_open or sizes[0] > _RUNS_AWAY * largest(*(curve.measured for curve in first))
    floor = given.comparisons[0].overall[name]["noise_floor"]
    return guessed and sizes[0] > _HIDES * max(*sizes[1:], 2.0 * floor)


def largest(*values: np.ndarray) -> float:
    """The largest magnitude of finite values (n,), without transmission errors; 0 if there are none."""
    finite = [np.abs(each[np.isfinite(each)]) for each in values]
    return max((float(np.quantile(each, 0.999)) for each in finite if len(each)), default=0.0)


def range_beside(traces: Sequence[Trace], band: float = 0.0) -> dict[str, Any]:
    """The range of an axis for all ``traces`` but the first model's, and for a ``band``, if any, around zero."""
    low, high = (-band, band) if band > 0.0 else (np.inf, -np.inf)
    for trace in traces:
        colours = trace.get("line", {}).get("color"), trace.get("marker", {}).get("color")
        if BEFORE in colours:
            continue
        spread = trace.get(_QUARTERS, {})
        for side in (-np.asarray(spread.get("arrayminus", 0.0)), np.asarray(spread.get("array", 0.0))):
            values = np.asarray(trace["y"]) + side
            if np.isfinite(values).any():
                low, high = min(low, float(np.nanmin(values))), max(high, float(np.nanmax(values)))
    room = _ROOM * (high - low)
    return {"range": [low - room, high + room]} if high > low else {}


def limit_words(name: str) -> str:
    """What a caption says of a limited axis."""
    return f" (the error of {name} goes beyond the axis; double-click shows all)"
