"""The null hypothesis: which numbers of a given model are free before any effect is added, and within what."""

from __future__ import annotations

import math

import numpy as np

from ..criteria import ANY_SIZE, LAG_TOLERANCE, SEARCHED_BEYOND_STARTS, TOLERANCE
from ..effects import catalogue
from ..measured.scales import INERTIAS
from ..model import Model
from ..model.roles import DRY_FRICTION, FRICTION
from .hypothesis import DRY_SCALE, EXACT, LAG, Free, Hypothesis

LAG_LIMIT = 2.0 * LAG_TOLERANCE
LAG_STEP = 1e-5  # own s


def null_hypothesis(model: Model, *, by_torque: bool = True) -> Hypothesis:
    """The given model, its constants free within their tolerances and its open values entirely free.

    Without torque data (``by_torque`` False) only open friction is free: it brings an output with backlash to rest.
    """
    if not by_torque:
        rubbing = [instance for instance in model.active.values() if instance.effect == DRY_FRICTION]
        friction = Free(DRY_SCALE, 1.0, 1.0, 1e-3, (1.0, EXACT))
        if any(instance.open for instance in rubbing):
            friction = Free(DRY_SCALE, *_possible_scales(model, DRY_FRICTION), 1e-3)
        return Hypothesis(model, {}, (friction,), np.ones(1)).with_sides()
    tolerance = max(model.constants[path].tolerance for path in INERTIAS if model.value(path) > 0.0)
    free = [
        Free("scale.inertia", 1.0 / ANY_SIZE, ANY_SIZE, 1e-3)
        if math.isinf(tolerance)
        else Free(
            "scale.inertia", 1.0 / SEARCHED_BEYOND_STARTS, SEARCHED_BEYOND_STARTS, 1e-3, (1.0, max(tolerance, EXACT))
        )
    ]
    for id in dict.fromkeys(instance.effect for instance in model.active.values()):
        if any(instance.open for instance in model.active.values() if instance.effect == id):
            free.append(Free(f"scale.{id}", *_possible_scales(model, id), 1e-3))
            if catalogue()[id].wave_angle is not None:
                free.append(Free(f"quarter.{id}", -ANY_SIZE, ANY_SIZE, 1e-3))
        elif id in FRICTION:
            free.append(Free(f"scale.{id}", 0.0, SEARCHED_BEYOND_STARTS, 1e-3, (1.0, TOLERANCE)))
    if not model.is_open:  # with other open values, a lag would only stand in for them: no model has one
        free.append(Free(LAG, -LAG_LIMIT, LAG_LIMIT, LAG_STEP, (0.0, LAG_TOLERANCE)))
    values = [1.0 if one.path.startswith("scale.") else 0.0 for one in free]
    return Hypothesis(model, {}, tuple(free), np.array(values)).with_sides()


def _possible_scales(model: Model, id: str) -> tuple[float, float]:
    """(lower, upper) factor on the sizes of an open effect; the sign of a wave is part of its phase."""
    size = catalogue()[id].parameters[0]
    lower, upper = -ANY_SIZE, ANY_SIZE
    if catalogue()[id].wave_angle is None:
        for instance in model.active.values():
            value = instance.parameters[size.name] if instance.effect == id else 0.0
            if value != 0.0:
                ends = sorted((size.lower / value, size.upper / value))
                lower, upper = max(lower, ends[0]), min(upper, ends[1])
        if size.lower > 0.0:
            lower = max(lower, 1.0 / ANY_SIZE)
    return lower, upper
