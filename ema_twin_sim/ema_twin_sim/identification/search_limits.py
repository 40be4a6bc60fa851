"""Search limits for a parameter without bounds: many times what the recordings reach.

Machines differ in size by many powers of ten, so no torque or stiffness is too large in itself. It is too large if the
torque that it makes at the speeds, accelerations and travel of these recordings is many times all that was measured.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..criteria import ANY_SIZE, NEARLY_ALL, SEARCHED_UP_TO
from ..effects import Effect, Parameter
from ..measured.observation import Observation
from ..plant.motion import ACCELERATION, OUTPUT_ANGLE, SPEED, TIME

LATEST = 0.02  # own s, of a fieldbus of the reference bench; later ones: discovery/late_output.py
LATEST_SAMPLES = 8.0  # or so many sample periods: electronics are late by cycles, however quick the mechanics are
_POWERS = {
    "N m": (0, 0, 0),
    "N m s/rad": (1, 0, 0),
    "N m s^2/rad^2": (2, 0, 0),
    "kg m^2": (0, 1, 0),
    "N m/rad": (0, 0, 1),
}
"""By unit: the powers of speed, acceleration and travel by which a parameter becomes a torque."""


@dataclass(frozen=True)
class Reached:
    """What recordings reach: N m, rad/s and rad/s² of the fast shaft, rad of the slow shaft, s.

    ``places`` are the smallest and largest angle of the slow shaft, by its encoder, and ``began`` the same of those at
    which the recordings begin. ``latest`` [s] is the longest delay of an encoder that is searched for.
    """

    torque: float
    speed: float
    acceleration: float
    travel: float
    duration: float
    places: tuple[float, float]
    began: tuple[float, float]
    latest: float


def reached(observations: Sequence[Observation]) -> Reached:
    """What these recordings reach in the rows that are judged."""
    judged = [o for o in observations if len(o.rows)]
    speed, acceleration = (
        float(np.quantile(np.concatenate([np.abs(o.motion[o.rows, column]) for o in judged]), NEARLY_ALL))
        if judged
        else 0.0
        for column in (SPEED, ACCELERATION)
    )
    ends = [o.output_origin + end(o.motion[:, OUTPUT_ANGLE]) for o in observations for end in (np.min, np.max)]
    began = [o.output_origin + float(o.motion[0, OUTPUT_ANGLE]) for o in observations]
    return Reached(
        max((float(np.abs(o.torque).max()) for o in judged), default=0.0),
        speed,
        acceleration,
        max((float(np.ptp(o.motion[:, OUTPUT_ANGLE])) for o in observations), default=0.0),
        max((float(np.ptp(o.motion[:, TIME])) for o in observations), default=0.0),
        (float(min(ends, default=0.0)), float(max(ends, default=0.0))),
        (min(began, default=0.0), max(began, default=0.0)),
        max(LATEST, LATEST_SAMPLES * max((o.period for o in observations), default=0.0)),
    )


def search_limits(effect: Effect, parameter: Parameter, of: Reached) -> tuple[float, float]:
    """(lower, upper) of a parameter in a search: its own bounds, or what the recordings reach if it has none."""
    lower, upper = parameter.lower, parameter.upper
    if math.isinf(upper):
        upper = _largest(effect, parameter, of)
        if parameter.unit == "rad/s":
            lower = max(lower, of.speed / ANY_SIZE)
        if parameter.unit == "s" and parameter.lower > 0.0:
            lower = max(lower, (1.0 - NEARLY_ALL) * of.duration)
    if math.isinf(lower):
        lower = -_largest(effect, parameter, of)
    return lower, max(lower, upper)


def _largest(effect: Effect, parameter: Parameter, of: Reached) -> float:
    size = effect.parameters[0]
    most = SEARCHED_UP_TO if parameter is size else ANY_SIZE
    if parameter.unit == "s" and parameter is size:
        return of.latest
    if parameter.unit in _POWERS:
        if parameter.lower > 0.0:  # a stiffness, which may be practically rigid
            return math.inf
        speed, acceleration, travel = _POWERS[parameter.unit]
        unit = of.speed**speed * of.acceleration**acceleration * of.travel**travel
        return most * of.torque / unit if unit > 0.0 and of.torque > 0.0 else math.inf
    known = {"rad/s": of.speed, "s": of.duration}.get(parameter.unit, 0.0)
    return ANY_SIZE * known if known > 0.0 else math.inf
