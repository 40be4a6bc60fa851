"""How large the residual is, and where along the quantity that it depends on."""

from __future__ import annotations

import numpy as np

from ..comparison.binning import bin_edges, quartiles, rows_by_bin
from ..criteria import STANDSTILL
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..model import Model
from ..model.own_units import shown
from ..plant.measured_motion import REQUIRED
from ..plant.motion import OUTPUT_ANGLE, SPEED, TIME
from ..quantities import quantity
from .search.trace import Search

_BINS = 24
_FEWEST = 5  # rows that a bin needs for a median
_UNITS = {"speed": "rad/s", "output_position": "rad", "time": "s", "load": "N m"}


def left_over_words(problem: EquationErrorProblem, found: Search, depends_on: tuple[str, ...]) -> str:
    """``from -23.8 mN m at 2.03 rad to 14.6 mN m at 2.83 rad, moving forward``: motor torque, medians of bins.

    For the first quantity that the residual depends on, in the direction in which it varies more. Empty if that
    quantity cannot be binned.
    """
    against = depends_on[0] if depends_on else ""
    if against not in _UNITS or not problem.size:
        return ""
    f = _without_generic_bases(found)
    left = problem.left_over(f.predicted)[: problem.size] * problem.noise
    x, speed = _along(problem, f, against)
    ways = {", moving forward": speed > STANDSTILL, ", moving backward": speed < -STANDSTILL}
    if against == "speed":
        ways = {"": np.ones(len(x), bool)}
    base = f.hypothesis.base
    size, unit = shown(base, 1.0, "N m")
    edges = bin_edges(x, _BINS, narrow=against in ("speed", "load"))
    best = (0.0, "")
    for way, chosen in ways.items():
        rows = rows_by_bin(x[chosen], edges, _FEWEST)
        if len(rows) < 2:
            continue
        _, median, _ = quartiles(left[chosen], rows)
        ends = (int(np.argmin(median)), int(np.argmax(median)))
        places = sorted((float(np.median(x[chosen][rows[k]])), float(median[k])) for k in ends)
        words = " to ".join(f"{quantity(size * torque, unit)} at {_place(base, at, against)}" for at, torque in places)
        best = max(best, (float(np.ptp(median)), f"from {words}{way}"))
    return best[1]


def _without_generic_bases(found: Search) -> Fit:
    """Fit of what was found, before any generic basis was added."""
    if not found.fit.hypothesis.generic_bases:
        return found.fit
    came = (
        turn
        for turn in found.changes
        if turn.after.hypothesis.generic_bases and not turn.before.hypothesis.generic_bases
    )
    return next((turn.before for turn in came), found.fit)


def _along(problem: EquationErrorProblem, f: Fit, against: str) -> tuple[np.ndarray, np.ndarray]:
    """The quantity and the speed [rad/s] (m,) at every torque row."""
    at = np.concatenate([o.motion[o.rows] for o in problem.observations])
    if against == "load":
        column = REQUIRED.index("transmitted")
        every = zip(problem.observations, f.predicted.required_by_recording, strict=True)
        return np.concatenate([required[o.rows, column] for o, required in every]), at[:, SPEED]
    if against == "output_position":
        origins = np.concatenate([np.full(len(o.rows), o.output_origin) for o in problem.observations])
        return at[:, OUTPUT_ANGLE] + origins, at[:, SPEED]
    return at[:, SPEED if against == "speed" else TIME], at[:, SPEED]


def _place(base: Model, value: float, against: str) -> str:
    value, unit = shown(base, value, _UNITS[against])
    if against == "output_position":
        return f"{value:.3g} {unit}"  # read off the output's counter: milliradians would be meaningless
    return quantity(value, unit)
